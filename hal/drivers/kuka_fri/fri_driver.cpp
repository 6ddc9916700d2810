#include "hal/drivers/kuka_fri/fri_driver.hpp"

#include <algorithm>
#include <cmath>

#include "hal/drivers/kuka_fri/hanging_load.hpp"
#include "hal/drivers/kuka_fri/wire/lwr_limits.hpp"

namespace colift::hal {
namespace {

constexpr double kRounding = 1e-6;
constexpr double kMinSlack_s = 0.001;  // an ordinary kernel's jitter is not a lost datagram
constexpr double kWrenchSlope_n_s = 500.0, kWrenchSlope_nm_s = 100.0;
constexpr int kGapCycles = 5;
constexpr double kRival_s = 1.0;             // a second sender that was silent for so long is gone
constexpr std::uint32_t kLoopbackNet = 127;  // 127.0.0.0/8: this machine
// a shorter one costs no answer, because the wait for a datagram has slack
constexpr double kStall_s = 0.004, kStallCycles = 2.0, kStallForgotten_s = 3.0;

FriQuality quality(const std::string& name) {
  return name == "perfect" ? FriQuality::Perfect : name == "bad" ? FriQuality::Bad : FriQuality::Ok;
}

SessionMachine::Settings settings(const FriConfig& c) {
  SessionMachine::Settings s;
  s.control = FriMode::of(c.control, c.null_space_posture).control;
  s.min_quality = quality(c.min_quality);
  s.start_external_nm = c.start_external_nm;
  s.warm_c = c.warm_c;
  s.hot_c = c.hot_c;
  s.velocity_rad_s = lwr_velocity_rad_s();
  return s;
}

double towards(double from, double to, double most) {
  return from + std::clamp(to - from, -most, most);
}

template <class To, class From>
void put(To& to, const From& from) {
  for (std::size_t i = 0; i < to.size(); ++i) to[i] = static_cast<float>(from[static_cast<Eigen::Index>(i)]);
}

}  // namespace

FriMode FriMode::of(const std::string& control, bool null_space_posture) {
  if (control == "position") return {FriControl::Position, 10, fri_flag::kPositionMode};
  if (control == "cartesian_impedance")
    return {FriControl::CartesianImpedance, 20,
            fri_flag::kCartesianImpedance | (null_space_posture ? fri_flag::kJointPosition : 0)};
  return {FriControl::JointImpedance, 30, fri_flag::kJointImpedance};
}

FriDriver::FriDriver(const FriConfig& c, const Endpoint& krc, std::unique_ptr<DatagramLink> link,
                     const Clock& k)
    : config(c),
      mode(FriMode::of(c.control, c.null_space_posture)),
      clock(k),
      wire(std::move(link), k, krc, {c.check_header, true}, c.check_sequence),
      session(settings(c)),
      hand_shake(make_hand_shake(c.script, mode.strategy)),
      joint_({lwr_limit_rad(), c.velocity_fraction * lwr_velocity_rad_s(), c.acceleration_rad_s2}),
      cart_({c.cart_velocity_m_s, c.cart_velocity_rad_s, 1.0, 3.0}),
      sample_(1e-3 * c.cycle_ms),
      period_s_(sample_.period_s()),
      limit_s_(period_s_) {
  start_gains();
}

void FriDriver::set_control(const std::string& control) {
  mode = FriMode::of(control, config.null_space_posture);
  session.set_control(mode.control);
  hand_shake->set_strategy(mode.strategy);
  tau_.setZero();
  wrench_.setZero();
}

FriReason FriDriver::sender_doubt() const {
  const PacketGate& gate = wire.gate();
  if (const auto& rival = gate.rival(); rival && seconds(arrived_at_ - rival->at) < kRival_s)
    return FriReason::SecondSender;
  const bool here = gate.sender() && gate.sender()->address >> 24 == kLoopbackNet;
  return gate.sender() && !here && config.krc.empty() ? FriReason::KrcNotNamed : FriReason::None;
}

void FriDriver::reset() {
  wire.reset();
  session = SessionMachine(settings(config));
  mode = FriMode::of(config.control, config.null_space_posture);
  hand_shake = make_hand_shake(config.script, mode.strategy);
  m = FriMeasurement{};
  open = seen = quiet = commanded_ = first_ = false;
  arrived_at_ = due_ = left_at_ = commanding_since_ = Timestamp{0};
  stall_s_ = 0.0;
  misses_at_ = Timestamp{0};
  misses_ = misses_before_ = 0;
  sample_ = SamplePeriod(1e-3 * config.cycle_ms);
  period_s_ = limit_s_ = sample_.period_s();
  steps_ = 1;
  krl_ = KrlChannels{};
  status = FriStatus{};
  start_gains();
}

void FriDriver::start_gains() {
  tau_.setZero();
  wrench_.setZero();
  borne_.setZero();
  stiffness_.setConstant(config.start_stiffness_nm_rad);
  damping_.setConstant(config.start_damping);
  cart_stiffness_.head<3>().setConstant(config.start_cart_stiffness_n_m);
  cart_stiffness_.tail<3>().setConstant(config.start_cart_stiffness_nm_rad);
  cart_damping_.setConstant(config.start_damping);
}

// From zero, because a controller refuses a start with a wrench; and from the second command on.
void FriDriver::bear_load() {
  if (first_) return;
  for (int i = 0; i < 6; ++i)
    borne_[i] = towards(borne_[i], hangs_[i], (i < 3 ? kWrenchSlope_n_s : kWrenchSlope_nm_s) * limit_s_);
}

bool FriDriver::mirrors_joints() const {
  return (mode.flags & fri_flag::kJointPosition) == 0;
}

std::uint64_t FriDriver::unsound_datagrams() const {
  return wire.gate().drops()[static_cast<std::size_t>(FriDrop::Content)];
}

FriDriver::Took FriDriver::take() {
  const Duration period(static_cast<Duration::rep>(1e9 * period_s_));
  const Duration slack(static_cast<Duration::rep>(1e9 * std::max(0.5 * period_s_, kMinSlack_s)));
  const Timestamp now = clock.now();
  if (!seen && arrived_at_ == Timestamp{0}) arrived_at_ = now;  // silence counts from here
  FriExchange::Packet packet;
  const Timestamp until = std::max(due_, now + period / 2);
  const auto got = wire.receive(until, period_s_, m, packet);
  note_stall(now, until);
  if (got != FriExchange::Got::Packet) {
    ++status.timeouts;
    const Timestamp then = clock.now();
    due_ = std::max(due_ + period, then + period);
    const double silent_s = seconds(then - arrived_at_);
    const bool lost = silent_s > lost_after_s(), broken = got == FriExchange::Got::Broken;
    status.unsound = unsound_datagrams() - unsound_before_;
    // a quarter of a period for the clock's and the machine's own jitter
    session.silence(std::floor(silent_s / period_s_ - 0.25), seen && lost, broken,
                    wire.gate().counter_set_by());
    if (lost) wire.gate().unlock();
    publish();
    return broken ? Took::Broken : Took::Nothing;
  }
  seen = open = true;
  commanded_ = false;
  if (packet.cycles > kGapCycles) status.unsound = unsound_datagrams() - unsound_before_;
  unsound_before_ = unsound_datagrams();
  arrived_at_ = packet.arrived_at;
  sample_.packet(static_cast<double>(m.measurement_period_s), arrived_at_, packet.cycles,
                 packet.first || packet.restarted, m.state == FriState::Command);
  period_s_ = sample_.period_s();
  limit_s_ = sample_.limit_s();
  due_ = arrived_at_ + Duration(static_cast<Duration::rep>(1e9 * period_s_)) + slack;
  measured_at_ = packet.first || packet.restarted
                     ? packet_clock_.start(arrived_at_)
                     : packet_clock_.advance(packet.cycles, period_s_, arrived_at_);
  const bool may_before = session.may_command();
  // before the KRL program is asked for anything
  status.doubt = sender_doubt();
  if (status.doubt != FriReason::None) session.refuse(status.doubt);
  session.measured(m, packet.cycles, period_s_, packet.restarted);
  hand_shake->step(session.ask(), m, std::min(packet.cycles, kGapCycles) * period_s_, config.script_s, krl_);
  session.script(hand_shake->sign(), hand_shake->code(), hand_shake->detour());
  note_misses(packet.first || packet.restarted);
  move_set_points(packet, may_before);
  publish();
  return Took::Packet;
}

// A process that is stopped, swapped out or starved sleeps past the end of its wait, or comes to it late.
// What the controller does then (quality, command mode, drives) has this one cause.
void FriDriver::note_stall(Timestamp asked, Timestamp until) {
  const Timestamp now = clock.now();
  const double overslept_s = seconds(now - std::max(asked, until));
  const double came_late_s = left_at_ == Timestamp{0} ? 0.0 : seconds(asked - left_at_);
  left_at_ = now;
  if (!session.may_command()) commanding_since_ = now;
  if (seconds(now - commanding_since_) > kStallForgotten_s) stall_s_ = 0.0;
  const double stall_s = std::max(overslept_s, came_late_s);
  if (seen && stall_s > std::max(kStall_s, kStallCycles * period_s_)) {
    stall_s_ = std::max(stall_s_, stall_s);
    commanding_since_ = now;
  }
}

// Those from before this program listened are nothing that it can mend.
void FriDriver::note_misses(bool first) {
  if (first) misses_before_ = misses_ = m.misses;
  if (!session.may_command() || seconds(arrived_at_ - misses_at_) < 1.0) return;
  misses_before_ = misses_at_ == Timestamp{0} ? m.misses : misses_;
  misses_ = m.misses;
  misses_at_ = arrived_at_;
}

void FriDriver::move_set_points(const FriExchange::Packet& packet, bool may_before) {
  const FriJoints followed = JointSetPoint::followed(m);
  const int unanswered = packet.cycles - 1 + wire.unheard(m);
  const bool gap = packet.cycles - 1 > kGapCycles;
  steps_ = std::min(packet.cycles, 4);
  led_ = false;
  if (SessionMachine::mirrors(m)) {
    led_ = true;
    joint_.mirror(followed);
    cart_.mirror(m.cart_measured);
    start_gains();
    hangs_ = wrench_against_load(m, state());
    return;
  }
  if (gap || packet.first || packet.restarted) {
    joint_.restart(followed);
    cart_.mirror(m.cart_measured);
  } else if (unanswered > 0) {
    (void)joint_.bridge(followed, unanswered);
  }
  if (mirrors_joints()) joint_.mirror(followed);
  if (session.may_command()) {
    first_ = first_ || !may_before || gap;
    if (first_) {
      // a stiffness of no spring: positions are followed whatever hangs there
      const bool springs = mode.control == FriControl::JointImpedance;
      joint_.expect_first(JointSetPoint::joints(m.q_measured_rad), state().tau_external_nm,
                          springs ? stiffness_ : JointVector(JointVector::Zero()));
      cart_.expect_first(m.cart_measured);
    }
    return;
  }
  brake();
  led_ = true;
}

void FriDriver::brake() {
  first_ = false;
  // in the period that arrivals agreed with: a datagram that says a shorter one must not lengthen the stop
  if (!mirrors_joints()) joint_.brake(period_s_);
  cart_.brake(period_s_);
}

void FriDriver::answer() {
  if (!open) return;
  open = false;
  if (!commanded_) {
    if (session.may_command()) {
      joint_.repeat();
      cart_.repeat();
    } else if (!led_) {
      brake();  // stopped since the datagram came
    }
    ++status.repeated;
  }
  FriCommand c;
  if (!quiet) c.krl = krl_;
  c.flags = hand_shake->detour() ? fri_flag::kPositionMode : mode.flags;
  c.q_rad = joint_.wire();
  c.cart = cart_.wire();
  put(c.tau_nm, tau_);
  c.wrench = to_wire_order(bounded_wrench(wrench_ + borne_));
  put(c.stiffness_nm_rad, stiffness_);
  put(c.damping, damping_);
  c.cart_stiffness = to_wire_order(cart_stiffness_);
  c.cart_damping = to_wire_order(cart_damping_);
  (void)wire.answer(c);
  JointVector stiffness = stiffness_;
  if (mode.control == FriControl::Position) stiffness.setConstant(1e6);
  if (mode.control == FriControl::CartesianImpedance) stiffness.setZero();  // joints follow the frame
  session.sent(joint_.q_rad(), stiffness, joint_.at_rest() && cart_.at_rest());
}

FriDriver::Took FriDriver::exchange() {
  answer();
  const Took took = take();
  if (took == Took::Packet) answer();
  return took;
}

FriLimit FriDriver::set(const ImpedanceCommand& c) {
  using What = FriLimit::What;
  for (int i = 0; i < kArmJoints; ++i) {
    const auto axis = static_cast<std::uint8_t>(i);
    const double most = std::min(lwr_torque_nm()[i], config.max_superposed_nm);
    if (!(c.stiffness_nm_rad[i] >= 0.0 && c.stiffness_nm_rad[i] <= kLwrMaxStiffness_nm_rad))
      return {What::Stiffness, axis, c.stiffness_nm_rad[i], kLwrMaxStiffness_nm_rad};
    if (!(c.damping_ratio[i] >= 0.0 && c.damping_ratio[i] <= 1.0))
      return {What::Damping, axis, c.damping_ratio[i], 1.0};
    if (!(std::abs(c.tau_superposed_nm[i]) <= most * (1.0 + kRounding)))
      return {What::Torque, axis, c.tau_superposed_nm[i], most};
  }
  if (const FriLimit bad = set_position(c.q_rad); bad.what != What::None) return bad;
  const double change = config.superposed_slope_nm_s * limit_s_;
  for (int i = 0; i < kArmJoints; ++i) tau_[i] = towards(tau_[i], c.tau_superposed_nm[i], change);
  stiffness_ = c.stiffness_nm_rad;
  joint_.set_stiffness(stiffness_);
  damping_ = c.damping_ratio;
  return {};
}

double FriDriver::lost_after_s() const {
  return std::max(config.silent_s, (kGapCycles + 0.5) * period_s_);
}

FriLimit FriDriver::set_position(const JointVector& q_rad) {
  const FriLimit bad = joint_.command(q_rad, steps_, limit_s_, granted());
  if (bad.what != FriLimit::What::None) return bad;
  commanded_ = true;
  first_ = false;
  return {};
}

FriLimit FriDriver::set(const JointVector* posture_rad, const Pose& X, const SixVector& stiffness,
                        const SixVector& damping_ratio, const SixVector& wrench) {
  using What = FriLimit::What;
  for (int i = 0; i < 6; ++i) {
    const auto axis = static_cast<std::uint8_t>(i);
    const double stiffest = i < 3 ? kLwrMaxCartStiffness_n_m : kLwrMaxCartStiffness_nm_rad;
    const double most = i < 3 ? kLwrPayloadForce_n : kLwrPayloadTorque_nm;
    if (!(stiffness[i] >= 0.0 && stiffness[i] <= stiffest))
      return {What::Stiffness, axis, stiffness[i], stiffest};
    if (!(damping_ratio[i] >= 0.0 && damping_ratio[i] <= 1.0))
      return {What::Damping, axis, damping_ratio[i], 1.0};
    if (!(std::abs(wrench[i]) <= most)) return {What::Wrench, axis, wrench[i], most};
  }
  if (const FriLimit bad = cart_.command(X, steps_, limit_s_, granted()); bad.what != What::None) return bad;
  if (posture_rad != nullptr && !mirrors_joints())
    if (const FriLimit bad = joint_.command(*posture_rad, steps_, limit_s_, granted());
        bad.what != What::None)
      return bad;
  for (int i = 0; i < 6; ++i)
    wrench_[i] = towards(wrench_[i], wrench[i], (i < 3 ? kWrenchSlope_n_s : kWrenchSlope_nm_s) * limit_s_);
  bear_load();
  cart_stiffness_ = stiffness;
  cart_damping_ = damping_ratio;
  commanded_ = true;
  first_ = false;
  return {};
}

void FriDriver::count_refused(const FriLimit& limit) {
  ++status.refused;
  status.last_refused = limit;
  publish();
}

ArmState FriDriver::state() const {
  ArmState s;
  s.measured_at = measured_at_;
  s.q_rad = JointSetPoint::joints(m.q_measured_rad);
  s.q_commanded_rad = JointSetPoint::joints(JointSetPoint::followed(m));
  s.tau_nm = JointSetPoint::joints(m.tau_measured_nm);
  s.tau_external_nm = JointSetPoint::joints(m.tau_external_nm);
  if (config.external_torque == "on_environment") s.tau_external_nm = -s.tau_external_nm;
  s.may_command = session.may_command();
  s.slow = session.slow();
  return s;
}

void FriDriver::publish() {
  FriStatus& s = status;
  if (s.session != session.session() || s.reason != session.reason())
    (void)events.push({clock.now(), session.session(), session.reason()});
  s.session = session.session();
  s.reason = session.reason();
  s.stage = session.stage();
  s.script = session.script_sign();
  s.script_code = session.script_code();
  s.may_command = session.may_command();
  s.slow = session.slow();
  s.joint = session.joint();
  s.number = session.number();
  s.state = m.state;
  s.quality = m.quality;
  s.control = m.control;
  s.power = m.power;
  s.error = m.error;
  s.warning = m.warning;
  s.answer_rate = m.answer_rate;
  s.latency_s = m.latency_s;
  s.jitter_s = m.jitter_s;
  s.hottest_c = *std::max_element(m.temperature_c.begin(), m.temperature_c.end());
  s.safety_limits = m.safety_limits;
  s.krc_misses = m.misses;
  s.recent_misses = m.misses >= misses_before_ ? m.misses - misses_before_ : 0;
  s.silent_s = lost_after_s();
  s.stall_s = stall_s_;
  s.period_s = period_s_;
  s.claimed_period_s = static_cast<double>(m.measurement_period_s);
  s.arrivals_s = sample_.disagrees_s().value_or(0.0);
  s.pose_mismatch_rad = 0.0;
  const FriJoints followed = JointSetPoint::followed(m);
  for (std::size_t i = 0; i < followed.size(); ++i) {
    const double off = std::abs(static_cast<double>(m.q_measured_rad[i] - followed[i]));
    if (off <= s.pose_mismatch_rad) continue;
    s.pose_mismatch_rad = off;
    s.mismatch_joint = static_cast<int>(i);
  }
  // in monitor mode the arm rests on the program's springs; when commanded, motions would be taken for loads
  if (m.state == FriState::Monitor) {
    const ArmState now = state();
    s.torque_reversed = mode.control != FriControl::Position &&
                        JointSetPoint::pulls_backwards(now.q_rad - now.q_commanded_rad, now.tau_external_nm);
  }
  s.krc = wire.gate().sender().value_or(Endpoint{});
  s.asked = mode.control;
  if (const auto& rival = wire.gate().rival()) {
    s.rival = rival->who;
    s.rival_datagrams = rival->datagrams;
  }
  s.received = wire.received;
  s.answered = wire.answered;
  s.late = wire.late;
  s.unsent = wire.unsent;
  s.lost = wire.lost;
  s.last_refusal = wire.last_refusal();
  s.drops = wire.gate().drops();
  latest_status.write(s);
  latest_measurement.write(m);
}

}  // namespace colift::hal
