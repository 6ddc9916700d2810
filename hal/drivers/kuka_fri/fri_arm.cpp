#include "hal/drivers/kuka_fri/fri_arm.hpp"

#include <algorithm>
#include <atomic>

#include "hal/drivers/kuka_fri/fri_driver.hpp"
#include "hal/drivers/kuka_fri/wire/lwr_limits.hpp"
#include "hal/os/realtime.hpp"
#include "hal/os/udp_link.hpp"

namespace colift::hal {
namespace {

constexpr int kCyclesAfterMonitor = 100;  // FRI's statistics are over so many; TUM's client does the same
constexpr int kNoTime = 2000;             // waits without time passing: the far end of a test is gone
constexpr double kTakeBack_s = 0.5;       // for the KRL program to hear that nobody waits any more
constexpr int kQuietCycles = 5;
constexpr double kScriptAfterStop_s = 1.0;

/// Bounds a loop of exchanges by time, and by waits in which no time passes.
class WaitTime {
 public:
  WaitTime(const Clock& clock, double most_s)
      : clock_(clock), until_(clock.now() + Duration(static_cast<Duration::rep>(1e9 * most_s))) {}
  bool left() {
    const Timestamp now = clock_.now();
    still_ = now == last_ ? still_ + 1 : 0;
    last_ = now;
    return now < until_ && still_ < kNoTime;
  }

 private:
  const Clock& clock_;
  Timestamp until_, last_{0};
  int still_ = 0;
};

Result<Endpoint> parse_krc(const std::string& text) {
  if (text.empty()) return Endpoint{};
  return parse_endpoint(text.find(':') == std::string::npos ? text + ":0" : text);
}

DeviceHealth::State device_state(const FriStatus& s) {
  using enum DeviceHealth::State;
  if (s.reason == FriReason::LinkBroken) return Failed;
  switch (s.session) {
    case FriSession::Silent:
      return s.reason == FriReason::NotOpen ? Absent : s.reason == FriReason::NoDatagram ? Opening : Lost;
    case FriSession::Monitor:
    case FriSession::GettingReady:
      return Opening;
    case FriSession::Command:
      return s.may_command                     ? Streaming
             : s.reason == FriReason::Stopped  ? Opening
             : s.reason == FriReason::NotAsked ? Opening
                                               : Stalled;
    case FriSession::Fault:
      return Failed;
  }
  return Absent;
}

}  // namespace

struct FriArm::Impl {
  Impl(const FriConfig& c, std::unique_ptr<DatagramLink> link, const Clock& clock)
      : config(c), driver(c, parse_krc(c.krc).value_or(Endpoint{}), std::move(link), clock) {}

  FriConfig config;
  FriDriver driver;
  std::atomic<bool> stopped{false};
  std::atomic<bool> configured{false};
  std::atomic<std::uint64_t> states{0};

  [[nodiscard]] bool krc_commands() const { return driver.m.state == FriState::Command; }
  [[nodiscard]] bool silent() const { return driver.session.session() == FriSession::Silent; }
  [[nodiscard]] std::string why() { return why_not(driver.latest_status.read(), config); }

  /// Asks for monitor mode, answering all the while.
  void leave() {
    driver.session.leave();
    const bool nobody_listens = config.script == "none";
    WaitTime timeout(driver.clock, config.stop_s);
    while (timeout.left() && !silent()) {
      (void)driver.exchange();
      if (!krc_commands() || nobody_listens) break;
    }
    WaitTime script(driver.clock, kScriptAfterStop_s);
    while (script.left() && !silent() && driver.hand_shake->sign() == ScriptSign::Working)
      (void)driver.exchange();
    driver.session.forget_requests();
    WaitTime after(driver.clock, config.stop_s);
    for (int i = 0; i < kCyclesAfterMonitor && after.left() && !silent(); ++i) (void)driver.exchange();
  }

  tl::unexpected<Error> refuse_to_start() {
    const FriReason reason = driver.session.reason();
    driver.publish();
    const std::string text = why();
    const bool certain = driver.status.doubt == FriReason::None;
    const bool asked = driver.hand_shake->sign() != ScriptSign::Unknown || (krc_commands() && certain);
    (void)driver.session.give_up();
    if (asked && !silent()) {
      driver.session.leave();
      WaitTime timeout(driver.clock, kTakeBack_s);
      while (timeout.left() && !silent()) {
        (void)driver.exchange();
        if (!krc_commands() && driver.hand_shake->sign() != ScriptSign::Working) break;
      }
      driver.session.forget_requests();
      (void)driver.exchange();
    }
    driver.session.refused(reason);
    driver.publish();
    const ErrorCode code =
        reason == FriReason::LinkLost || reason == FriReason::NoDatagram || reason == FriReason::LinkBroken
            ? ErrorCode::LinkLost
        : reason == FriReason::DriveError || reason == FriReason::DriveHot ? ErrorCode::DeviceFault
                                                                           : ErrorCode::NotReady;
    return failure(code, "fri.activate", text);
  }

  /// Why no command can be taken now; nullptr when one can.
  [[nodiscard]] const char* closed(FriControl control) const {
    if (!configured) return "not configured";
    if (stopped) return short_words(FriReason::Stopped);
    if (!driver.session.may_command()) return short_words(driver.session.reason());
    if (!driver.open) return "no open cycle";
    if (driver.mode.control != control) return short_words(FriReason::WrongControl);
    return nullptr;
  }

  Result<> taken(const FriLimit& limit) {
    if (limit.what != FriLimit::What::None) {
      driver.count_refused(limit);
      return failure(ErrorCode::LimitExceeded, "fri.command", short_words(limit));
    }
    driver.answer();
    return {};
  }
};

FriArm::FriArm(const FriConfig& config, std::unique_ptr<DatagramLink> link, const Clock& clock)
    : impl_(std::make_unique<Impl>(config, std::move(link), clock)) {
  impl_->driver.status.reason = FriReason::NotOpen;
  impl_->driver.latest_status.write(impl_->driver.status);
}

FriArm::~FriArm() {
  shut_down();
}

Result<> FriArm::configure() {
  Impl& a = *impl_;
  constexpr const char* kWhere = "fri.configure";
  if (auto krc = parse_krc(a.config.krc); !krc) return tl::unexpected<Error>(krc.error());
  if (a.configured) shut_down();
  FriDriver& d = a.driver;
  d.reset();
  a.states = 0;
  if (auto opened = d.wire.open(); !opened) return opened;
  WaitTime timeout(d.clock, a.config.first_s);
  while (timeout.left() && !d.seen)
    if (d.exchange() == FriDriver::Took::Broken) break;
  d.publish();
  if (!d.seen) {
    const std::string text = a.why();
    d.wire.close();
    d.status.reason = FriReason::NoDatagram;
    d.latest_status.write(d.status);
    return failure(ErrorCode::LinkLost, kWhere, text);
  }
  a.configured = true;
  return {};
}

Result<> FriArm::activate() {
  Impl& a = *impl_;
  if (!a.configured)
    return failure(ErrorCode::NotReady, "fri.activate", "the arm is not open; configure() comes first");
  FriDriver& d = a.driver;
  (void)stay_on_cpu(a.config.cpu);  // this is the thread that answers; without such a CPU it runs anywhere
  a.stopped = false;
  d.answer();
  d.session.activate();
  WaitTime timeout(d.clock, a.config.ready_s);
  while (timeout.left()) {
    (void)d.exchange();
    if (d.session.may_command()) return {};
    if (a.stopped) d.session.stop();
    if (a.silent() || d.session.stage() == ReadyStage::Refused) break;
  }
  return a.refuse_to_start();
}

Result<> FriArm::set_control(const std::string& control) {
  Impl& a = *impl_;
  constexpr const char* kWhere = "fri.set_control";
  if (control != "joint_impedance" && control != "position" && control != "cartesian_impedance")
    return failure(
        ErrorCode::BadInput, kWhere,
        "\"" + control + "\" is no control; expected joint_impedance, position or cartesian_impedance");
  if (!a.configured)
    return failure(ErrorCode::NotReady, kWhere, "the arm is not open; configure() comes first");
  const bool other = FriMode::of(control, false).control != a.driver.mode.control;
  if (!other) return {};
  if (a.krc_commands() && !a.silent())
    return failure(
        ErrorCode::NotReady, kWhere,
        "the KRC is in command mode, where the strategy may not change: deactivate() comes first; if "
        "that did not end it, a person has to, at the panel");
  if (!script_sets_strategy(a.config.script))
    return failure(
        ErrorCode::NotReady, kWhere,
        "the KRL program (script: " + a.config.script +
            ") keeps a strategy of its own; those that change it are colift, stanford, cep and openkc");
  a.driver.set_control(control);
  a.driver.publish();
  return {};
}

FriControl FriArm::control() const {
  return impl_->driver.mode.control;
}

void FriArm::deactivate() noexcept {
  Impl& a = *impl_;
  if (!a.configured) return;
  a.stopped = true;
  if (a.silent() || (!a.krc_commands() && a.driver.session.ask() == Ask::Nothing)) {
    a.driver.session.leave();
    a.driver.session.forget_requests();
  } else {
    a.leave();
  }
  a.driver.publish();
}

void FriArm::shut_down() noexcept {
  Impl& a = *impl_;
  if (!a.configured) return;
  deactivate();
  FriDriver& d = a.driver;
  if (a.config.end_script && !a.silent()) {
    d.session.close();
    WaitTime timeout(d.clock, kScriptAfterStop_s + kTakeBack_s);
    while (timeout.left() && !a.silent()) (void)d.exchange();
  }
  // nothing stands there for the next program or the next client; only colift's own numbers a request, so
  // that an old one does no harm, and would take zeros for one
  if (a.config.script != "colift") {
    d.quiet = true;
    WaitTime timeout(d.clock, kTakeBack_s);
    for (int i = 0; i < kQuietCycles && timeout.left() && !a.silent(); ++i) (void)d.exchange();
  }
  a.configured = false;
  d.wire.close();
}

Result<ArmState> FriArm::wait_cycle() {
  Impl& a = *impl_;
  constexpr const char* kWhere = "fri.wait_cycle";
  if (!a.configured) return failure(ErrorCode::NotReady, kWhere, "not configured");
  FriDriver& d = a.driver;
  if (a.stopped) d.session.stop();
  d.answer();
  const FriDriver::Took took = d.take();
  if (took != FriDriver::Took::Packet) {
    if (took == FriDriver::Took::Broken || a.silent())
      return failure(ErrorCode::LinkLost, kWhere, short_words(d.session.reason()));
    return failure(ErrorCode::Timeout, kWhere, "no datagram");
  }
  if (d.session.garbage()) {
    d.answer();
    return failure(ErrorCode::BadReply, kWhere, short_words(FriReason::JointJump));
  }
  ++a.states;
  const ArmState state = d.state();
  if (!state.may_command) d.answer();
  return state;
}

Result<> FriArm::command(const ImpedanceCommand& command) {
  if (const char* why = impl_->closed(FriControl::JointImpedance))
    return failure(ErrorCode::NotReady, "fri.command", why);
  return impl_->taken(impl_->driver.set(command));
}

Result<> FriArm::command_position(const JointVector& q_rad) {
  if (const char* why = impl_->closed(FriControl::Position))
    return failure(ErrorCode::NotReady, "fri.command", why);
  return impl_->taken(impl_->driver.set_position(q_rad));
}

Result<> FriArm::command_cartesian(const CartesianCommand& c) {
  if (const char* why = impl_->closed(FriControl::CartesianImpedance))
    return failure(ErrorCode::NotReady, "fri.command", why);
  return impl_->taken(impl_->driver.set(c.posture_rad ? &*c.posture_rad : nullptr, c.X, c.stiffness,
                                        c.damping_ratio, c.wrench));
}

ArmAbilities FriArm::abilities() const {
  ArmAbilities can;
  can.cartesian_impedance = can.position = true;
  can.max_stiffness_nm_rad = kLwrMaxStiffness_nm_rad;
  for (int i = 0; i < kArmJoints; ++i)
    can.max_superposed_nm[i] = std::min(lwr_torque_nm()[i], impl_->config.max_superposed_nm);
  can.joint_impedance = can.superposed_torque = impl_->driver.mode.control == FriControl::JointImpedance;
  return can;
}

void FriArm::stop() noexcept {
  impl_->stopped = true;
}

DeviceHealth FriArm::health() const {
  const FriStatus s = status();
  DeviceHealth h;
  h.state = device_state(s);
  h.accepted = s.states;
  h.rejected = s.refused + s.timeouts;
  for (const std::uint64_t d : s.drops) h.rejected += d;
  if (s.reason != FriReason::None && s.reason != FriReason::NotAsked && s.reason != FriReason::NotOpen)
    h.last_error = why_not(s, impl_->config);
  if (s.torque_reversed)
    h.last_error += (h.last_error.empty() ? "" : "; ") + describe_torque_sign(s, impl_->config);
  if (const std::string slow = why_slow(s, impl_->config); !slow.empty())
    h.last_error += (h.last_error.empty() ? "slow: " : "; slow: ") + slow;
  return h;
}

FriStatus FriArm::status() const {
  FriStatus s = impl_->driver.latest_status.read();
  s.states = impl_->states;
  return s;
}
FriMeasurement FriArm::measurement() const {
  return impl_->driver.latest_measurement.read();
}

SixVector FriArm::external_wrench() const {
  const SixVector w = from_wire_order(measurement().wrench_external);
  return impl_->config.external_torque == "on_environment" ? SixVector(-w) : w;
}

std::optional<FriEvent> FriArm::next_event() {
  return impl_->driver.events.pop();
}
const AnswerTimes& FriArm::answer_times() const {
  return impl_->driver.wire.answer_times();
}
const FriConfig& FriArm::config() const {
  return impl_->config;
}

Result<std::unique_ptr<FriArm>> make_fri_arm(const FriConfig& config, const Clock& clock) {
  auto local = parse_endpoint(config.address + ":" + std::to_string(config.port));
  if (!local) return tl::unexpected<Error>(local.error());
  if (auto krc = parse_krc(config.krc); !krc) return tl::unexpected<Error>(krc.error());
  return std::make_unique<FriArm>(config, make_udp_link(*local), clock);
}

}  // namespace colift::hal
