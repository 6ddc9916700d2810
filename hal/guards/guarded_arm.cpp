#include "hal/guards/guarded_arm.hpp"

#include <fmt/format.h>

#include <array>
#include <atomic>
#include <cmath>
#include <optional>
#include <string_view>

#include "hal/guards/braking_law.hpp"
#include "hal/guards/cycle_time.hpp"
#include "hal/types/latest_value.hpp"
#include "hal/types/short_text.hpp"
#include "hal/types/units.hpp"

namespace colift::hal {

namespace {

constexpr double kMinCycle_s = 0.0005;        // no arm is faster: two states nearer than this are one
constexpr double kRounding = 1e-9;            // relative; a command at its limit is not a command beyond it
constexpr double kStartTolerance_rad = 1e-4;  // finer than the arm's repeatability of 0.05 mm
constexpr double kStartTorque_nm = 1.0;       // the arm's controller asks for near zero at its start
constexpr double kBeyondStop_rad = 0.1;       // the arm's own limits end there; a state beyond is garbage
constexpr double kJumpParts = 2.0;  // of the velocity limit: faster than any arm, slower than garbage
constexpr double kJump_rad = 0.01;
constexpr double kGapCycles = 5.5;  // over no more the arm moves on by itself
constexpr double kStuck_s = 0.1;
constexpr double kStuck_rad = 0.01;

bool finite(const JointVector& v) {
  return v.allFinite();
}

std::string joint(int i) {
  return fmt::format("A{}", i + 1);
}

}  // namespace

struct GuardedArm::Impl {
  std::unique_ptr<Arm> inner;
  GuardConfig config;
  std::array<JointBounds, kArmJoints> bounds;
  JointVector hard_lower, hard_upper, torque_limit;

  std::atomic<bool> active{false};
  // told to whoever asks, from another thread
  std::atomic<std::uint64_t> accepted{0}, rejected{0};
  LatestValue<ShortText> last_error;

  // what was measured
  CycleTime time;                               ///< Of all states, good or not.
  std::optional<Timestamp> other_since, other;  ///< States on a clock of their own, older than `time`.
  std::optional<ArmState> good;
  Timestamp stuck_since{0};
  JointVector stuck_command = JointVector::Zero();

  // what was commanded
  bool cycle_open = false;
  bool engaged = false;  ///< `sent` is what the arm follows; else the next command starts anew.
  ImpedanceCommand sent;
  JointVector dq = JointVector::Zero();

  void forget() {
    time.reset();
    other.reset();
    good.reset();
    cycle_open = engaged = false;
  }

  tl::unexpected<Error> reject(ErrorCode code, const char* where, std::string detail) {
    ++rejected;
    last_error.write(ShortText(fmt::format("{}: {}", where, detail)));
    return failure(code, where, std::move(detail));
  }

  /// True for a state that came twice or late. If nothing but older states comes for a while, the arm's
  /// clock was set back: then everything starts anew.
  bool out_of_order(Timestamp at) {
    if (!time.last() || seconds(at - *time.last()) >= kMinCycle_s) {
      other.reset();
      return false;
    }
    if (!other || at <= *other || seconds(at - *other) > config.stale_s) other_since = at;
    other = at;
    if (seconds(at - *other_since) <= config.stale_s) return true;
    forget();
    return false;
  }

  std::optional<std::string> implausible(const ArmState& s) const {
    if (!finite(s.q_rad) || !finite(s.q_commanded_rad)) return "a joint position is not a number";
    if (!finite(s.tau_nm) || !finite(s.tau_external_nm)) return "a joint torque is not a number";
    for (int i = 0; i < kArmJoints; ++i) {
      if (s.q_rad[i] < hard_lower[i] - kBeyondStop_rad || s.q_rad[i] > hard_upper[i] + kBeyondStop_rad)
        return fmt::format("{} is measured at {:.3f} rad (its stops are at {:.3f} and {:.3f})", joint(i),
                           s.q_rad[i], hard_lower[i], hard_upper[i]);
      if (!good) continue;
      const double dt = seconds(s.measured_at - good->measured_at);
      const double most = kJump_rad + kJumpParts * bounds[static_cast<std::size_t>(i)].velocity_rad_s * dt;
      if (const double jump = std::abs(s.q_rad[i] - good->q_rad[i]); jump > most)
        return fmt::format(
            "{} jumped by {:.4f} rad in {:.1f} ms (by itself at most {:.4f}): struck, or measured wrong",
            joint(i), jump, 1e3 * dt, most);
    }
    return std::nullopt;
  }

  /// True while the measured position keeps its last bit although the command has moved on for a while.
  bool stuck(const ArmState& s) {
    if (!good || !engaged || s.q_rad != good->q_rad) {
      stuck_since = s.measured_at;
      stuck_command = sent.q_rad;
      return false;
    }
    return seconds(s.measured_at - stuck_since) > kStuck_s &&
           (sent.q_rad - stuck_command).cwiseAbs().maxCoeff() > kStuck_rad;
  }

  Result<> send(const ImpedanceCommand& c, double dt) {
    cycle_open = false;
    if (auto done = inner->command(c); !done) {
      engaged = false;  // nobody knows what the arm follows now: from the measured pose
      ++rejected;
      return done;
    }
    if (dt > 0.0) dq = (c.q_rad - sent.q_rad) / dt;
    sent = c;
    engaged = true;
    return {};
  }

  /// Answers the open cycle with the next step on the way to rest.
  void brake() {
    if (!engaged || !active) {
      cycle_open = false;
      return;
    }
    const double dt = time.step_s();
    ImpedanceCommand c = sent;
    for (int i = 0; i < kArmJoints; ++i)
      c.q_rad[i] += dt * braking_velocity(sent.q_rad[i], dq[i], dt, bounds[static_cast<std::size_t>(i)]);
    (void)send(c, dt);
  }

  /// The first command of a session: the measured pose, at rest, nothing superposed.
  void start() {
    sent = ImpedanceCommand{};
    sent.q_rad = good->q_rad;
    sent.stiffness_nm_rad = sent.stiffness_nm_rad.cwiseMin(config.max_stiffness_nm_rad);
    dq.setZero();
    stuck_since = good->measured_at;
    stuck_command = sent.q_rad;
  }

  std::optional<std::string> bad_gains(const ImpedanceCommand& c) const {
    if (!finite(c.q_rad)) return "a joint position is not a number";
    if (!finite(c.stiffness_nm_rad) || !finite(c.damping_ratio))
      return "a stiffness or damping is not a number";
    if (!finite(c.tau_superposed_nm)) return "a superposed torque is not a number";
    for (int i = 0; i < kArmJoints; ++i) {
      if (c.stiffness_nm_rad[i] < 0.0 || c.stiffness_nm_rad[i] > config.max_stiffness_nm_rad)
        return fmt::format("stiffness of {} is {:.1f} N m/rad (limit {:.1f})", joint(i),
                           c.stiffness_nm_rad[i], config.max_stiffness_nm_rad);
      if (c.damping_ratio[i] < 0.0 || c.damping_ratio[i] > 1.0)
        return fmt::format("damping of {} is {:.3f} (0 to 1)", joint(i), c.damping_ratio[i]);
      if (std::abs(c.tau_superposed_nm[i]) > torque_limit[i])
        return fmt::format("superposed torque of {} is {:.1f} N m (limit {:.1f})", joint(i),
                           c.tau_superposed_nm[i], torque_limit[i]);
    }
    return std::nullopt;
  }

  /// Which limit a step would break; a step within rounding of its limit is put on the limit.
  std::optional<std::string> bad_step(ImpedanceCommand& c, double dt) const {
    for (int i = 0; i < kArmJoints; ++i) {
      const JointBounds& b = bounds[static_cast<std::size_t>(i)];
      const double slope = std::abs(c.tau_superposed_nm[i] - sent.tau_superposed_nm[i]);
      if (slope > config.superposed_slope_nm_s * dt * (1.0 + kRounding))
        return fmt::format("superposed torque of {} changes by {:.2f} N m in {:.1f} ms (limit {:.0f} N m/s)",
                           joint(i), slope, 1e3 * dt, config.superposed_slope_nm_s);
      const VelocityRange allowed = allowed_velocity(sent.q_rad[i], dq[i], dt, b);
      const double v = (c.q_rad[i] - sent.q_rad[i]) / dt;
      const double rounding = kRounding * b.velocity_rad_s;
      if (v >= allowed.low && v <= allowed.high) continue;
      if (v >= allowed.low - rounding && v <= allowed.high + rounding) {
        c.q_rad[i] = sent.q_rad[i] + dt * std::clamp(v, allowed.low, allowed.high);
        continue;
      }
      if (std::abs(v) > b.velocity_rad_s)
        return fmt::format("{} would move with {:.3f} rad/s (limit {:.3f})", joint(i), v, b.velocity_rad_s);
      if (const double a = (v - dq[i]) / dt; std::abs(a) > b.acceleration_rad_s2)
        return fmt::format("{} would accelerate with {:.2f} rad/s^2 (limit {:.2f})", joint(i), a,
                           b.acceleration_rad_s2);
      return fmt::format(
          "{} at {:.4f} rad with {:.3f} rad/s could not stop before its limit ({:.4f} to {:.4f})", joint(i),
          c.q_rad[i], v, b.lower_rad, b.upper_rad);
    }
    return std::nullopt;
  }
};

GuardedArm::GuardedArm(std::unique_ptr<Arm> inner, const RobotModel& model, const GuardConfig& config)
    : impl_(std::make_unique<Impl>()) {
  impl_->inner = std::move(inner);
  impl_->config = config;
  impl_->hard_lower = model.lower_rad();
  impl_->hard_upper = model.upper_rad();
  impl_->torque_limit = model.effort_nm().cwiseMin(config.max_superposed_nm);
  const JointVector velocity =
      (config.velocity_fraction * model.velocity_rad_s()).cwiseMin(config.max_velocity_rad_s);
  const double margin = deg_to_rad(config.limit_margin_deg);
  for (int i = 0; i < kArmJoints; ++i)
    impl_->bounds[static_cast<std::size_t>(i)] = {impl_->hard_lower[i] + margin,
                                                  impl_->hard_upper[i] - margin, velocity[i],
                                                  config.acceleration_rad_s2};
}

GuardedArm::~GuardedArm() = default;

Result<> GuardedArm::configure() {
  impl_->active = false;
  impl_->forget();
  return impl_->inner->configure();
}

Result<> GuardedArm::activate() {
  auto done = impl_->inner->activate();
  if (!done) return done;
  impl_->forget();
  impl_->active = true;
  return {};
}

void GuardedArm::deactivate() noexcept {
  impl_->active = false;
  impl_->inner->deactivate();
}

DeviceHealth GuardedArm::health() const {
  DeviceHealth h = impl_->inner->health();
  h.rejected += impl_->rejected;
  if (const ShortText error = impl_->last_error.read(); !error.empty()) h.last_error = error.str();
  return h;
}

Result<ArmState> GuardedArm::wait_cycle() {
  Impl& g = *impl_;
  if (g.cycle_open) g.brake();  // nobody answered the last cycle

  auto state = g.inner->wait_cycle();
  if (!state) {
    if (state.error().code != ErrorCode::Timeout) g.engaged = false;
    ++g.rejected;
    return state;
  }
  if (g.out_of_order(state->measured_at))
    return g.reject(ErrorCode::BadReply, "arm.wait_cycle",
                    fmt::format("a state {:.3f} ms after the last one: doubled or out of order",
                                1e3 * seconds(state->measured_at - *g.time.last())));
  const double gap_s = g.time.advance(state->measured_at);
  if (!state->may_command || gap_s > std::max(g.config.stale_s, kGapCycles * g.time.period_s()))
    g.engaged = false;

  if (const auto why = g.implausible(*state)) {
    g.brake();
    return g.reject(ErrorCode::BadReply, "arm.wait_cycle", *why);
  }
  if (g.stuck(*state)) {
    g.brake();
    return g.reject(ErrorCode::DeviceFault, "arm.wait_cycle",
                    fmt::format("the measured position has not changed for {:.0f} ms while the command moved",
                                1e3 * seconds(state->measured_at - g.stuck_since)));
  }
  g.good = *state;
  g.cycle_open = true;
  ++g.accepted;
  return state;
}

Result<> GuardedArm::command(const ImpedanceCommand& command) {
  Impl& g = *impl_;
  constexpr const char* kWhere = "arm.command";
  if (!g.active)
    return g.reject(ErrorCode::NotReady, kWhere, "the arm is stopped; activate() lets it act again");
  if (!g.cycle_open)
    return g.reject(ErrorCode::NotReady, kWhere, "there is no cycle to answer; each is answered once");
  if (!g.good->may_command)
    return g.reject(ErrorCode::NotReady, kWhere, "the arm's controller accepts no commands");

  const bool first = !g.engaged;
  if (first) g.start();
  const double dt = g.time.step_s();
  ImpedanceCommand c = command;
  std::optional<std::string> why = g.bad_gains(c);
  if (!why && first) {
    const double off = (c.q_rad - g.sent.q_rad).cwiseAbs().maxCoeff();
    if (off > kStartTolerance_rad)
      why = fmt::format("the first command is {:.4f} rad away from the measured pose (limit {:.4f})", off,
                        kStartTolerance_rad);
    else if (const double most = c.tau_superposed_nm.cwiseAbs().maxCoeff(); most > kStartTorque_nm)
      why = fmt::format("the first command superposes {:.1f} N m (limit {:.1f})", most, kStartTorque_nm);
    c.q_rad = g.sent.q_rad;
  }
  if (!why && !first) why = g.bad_step(c, dt);
  if (!why) return g.send(c, first ? 0.0 : dt);

  if (first)
    (void)g.send(g.sent, 0.0);
  else
    g.brake();
  return g.reject(ErrorCode::LimitExceeded, kWhere, *why);
}

ArmAbilities GuardedArm::abilities() const {
  ArmAbilities can = impl_->inner->abilities();
  can.max_stiffness_nm_rad = std::min(can.max_stiffness_nm_rad, impl_->config.max_stiffness_nm_rad);
  can.max_superposed_nm = can.max_superposed_nm.cwiseMin(impl_->torque_limit);
  return can;
}

void GuardedArm::stop() noexcept {
  impl_->active = false;
  impl_->inner->stop();
}

}  // namespace colift::hal
