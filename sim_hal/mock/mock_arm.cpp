#include "sim_hal/mock/mock_arm.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "hal/types/units.hpp"

namespace colift::sim_hal {

using hal::ErrorCode;
using hal::JointVector;
using State = hal::DeviceHealth::State;

namespace {

constexpr int kLateCycles = 3;
constexpr double kJump_rad = 0.3;

}  // namespace

JointVector ArmScript::lwr_limit_rad() {
  JointVector limit;
  limit << 170, 120, 170, 120, 170, 120, 170;
  return limit * hal::kRadPerDeg;
}

JointVector ArmScript::lwr_velocity_rad_s() {
  JointVector velocity;
  velocity << 110, 110, 128, 128, 204, 184, 184;
  return velocity * hal::kRadPerDeg;
}

MockArm::MockArm(ArmScript script, hal::ManualClock& clock)
    : script_(std::move(script)),
      clock_(clock),
      start_(clock.now()),
      moved_until_(clock.now()),
      q_rad_(script_.start_rad),
      goal_rad_(script_.start_rad) {}

std::uint64_t MockArm::cycles_until_now() const {
  return static_cast<std::uint64_t>(
      std::max<hal::Duration::rep>((clock_.now() - start_) / script_.period, 0));
}

void MockArm::move(hal::Duration by) {
  if (stopped_ || !active_) goal_rad_ = q_rad_;
  const JointVector reach = script_.velocity_rad_s * hal::seconds(by);
  q_rad_ += (goal_rad_ - q_rad_).cwiseMax(-reach).cwiseMin(reach);
}

bool MockArm::may_command() const {
  return active_ && !stopped_;
}

hal::ArmState MockArm::measure() const {
  hal::ArmState state;
  state.measured_at = clock_.now();
  state.q_rad = q_rad_;
  state.q_commanded_rad = goal_rad_;
  if (script_.external_nm) state.tau_external_nm = script_.external_nm(clock_.now(), q_rad_);
  state.tau_nm = state.tau_external_nm;
  if (may_command() && last_command_) state.tau_nm += last_command_->tau_superposed_nm;
  state.may_command = may_command();
  return state;
}

tl::unexpected<hal::Error> MockArm::drop_link(const char* where) {
  active_ = false;
  goal_rad_ = q_rad_;
  health_.state = State::Lost;
  health_.last_error = fmt::format("the arm is unplugged since {:.3f} s", hal::seconds(clock_.now()));
  return hal::failure(ErrorCode::LinkLost, where, health_.last_error);
}

hal::Result<> MockArm::configure() {
  constexpr auto kWhere = "mock_arm.configure";
  const JointVector& limit = script_.limit_rad;
  const bool good = script_.period.count() > 0 && (limit.array() > 0).all() &&
                    (script_.velocity_rad_s.array() > 0).all() &&
                    (script_.start_rad.array().abs() <= limit.array()).all();
  if (!good) {
    health_.state = State::Failed;
    health_.last_error =
        fmt::format("a script needs a period (found {} ns), limits above 0, and a start within them",
                    script_.period.count());
    return hal::failure(ErrorCode::BadConfig, kWhere, health_.last_error);
  }
  if (faults_.at(cycles_until_now()) == Fault::Unplug) return drop_link(kWhere);
  active_ = false;
  health_.state = State::Opening;
  return {};
}

hal::Result<> MockArm::activate() {
  if (health_.state != State::Opening && health_.state != State::Streaming && health_.state != State::Stalled)
    return hal::failure(ErrorCode::NotReady, "mock_arm.activate",
                        "the arm is not open, call configure() first");
  goal_rad_ = q_rad_;
  last_command_.reset();
  active_ = true;
  stopped_ = false;
  health_.state = State::Streaming;
  return {};
}

void MockArm::deactivate() noexcept {
  active_ = false;
  goal_rad_ = q_rad_;
  if (health_.state == State::Streaming || health_.state == State::Stalled) health_.state = State::Opening;
}

hal::Result<hal::ArmState> MockArm::wait_cycle() {
  constexpr auto kWhere = "mock_arm.wait_cycle";
  if (health_.state == State::Lost) return hal::failure(ErrorCode::LinkLost, kWhere, health_.last_error);
  if (health_.state == State::Absent || health_.state == State::Failed)
    return hal::failure(ErrorCode::NotReady, kWhere, "the arm is not open, call configure() first");

  const std::uint64_t cycle = cycles_until_now();
  const hal::Timestamp due = start_ + script_.period * static_cast<hal::Duration::rep>(cycle + 1);
  const auto fault = faults_.at(cycle);
  // a command for a cycle that was lost never arrived
  if (fault == Fault::Drop) goal_rad_ = q_rad_;
  clock_.advance(due - clock_.now());
  move(due - moved_until_);
  moved_until_ = due;
  cycle_ = cycle;
  answered_ = false;

  if (fault == Fault::Unplug) return drop_link(kWhere);
  if (fault == Fault::Drop) {
    answered_ = true;
    ++health_.rejected;
    health_.state = State::Stalled;
    health_.last_error = fmt::format("cycle {} brought no state", cycle);
    return hal::failure(ErrorCode::Timeout, kWhere, health_.last_error);
  }
  ++health_.accepted;
  health_.state = active_ ? State::Streaming : State::Opening;
  hal::ArmState state = measure();
  if (!fault) {
    last_good_ = state;
  } else if (fault == Fault::Freeze) {
    if (last_good_) state = *last_good_;
  } else if (fault == Fault::Jump) {
    state.q_rad[1] += kJump_rad;
  } else if (fault == Fault::Nan) {
    state.q_rad[3] = std::numeric_limits<double>::quiet_NaN();
  } else if (fault == Fault::Late) {
    const hal::Duration later = kLateCycles * script_.period;
    clock_.advance(later);
    move(later);
    moved_until_ += later;
  }
  return state;
}

hal::Result<> MockArm::command(const hal::ImpedanceCommand& command) {
  constexpr auto kWhere = "mock_arm.command";
  if (!may_command())
    return hal::failure(ErrorCode::NotReady, kWhere,
                        active_ ? "the arm was stopped, call activate() first" : "the arm is not active");
  if (answered_)
    return hal::failure(ErrorCode::NotReady, kWhere, "this cycle has its answer, call wait_cycle() first");
  const bool numbers = command.q_rad.allFinite() && command.stiffness_nm_rad.allFinite() &&
                       command.damping_ratio.allFinite() && command.tau_superposed_nm.allFinite();
  if (!numbers)
    return hal::failure(ErrorCode::LimitExceeded, kWhere, "a number of the command is not finite");
  for (int i = 0; i < hal::kArmJoints; ++i)
    if (std::abs(command.q_rad[i]) > script_.limit_rad[i])
      return hal::failure(ErrorCode::LimitExceeded, kWhere,
                          fmt::format("A{} to {:.3f} rad, but its limit is {:.3f} rad", i + 1,
                                      command.q_rad[i], script_.limit_rad[i]));
  if ((command.stiffness_nm_rad.array() < 0).any() || (command.damping_ratio.array() < 0).any())
    return hal::failure(ErrorCode::LimitExceeded, kWhere, "stiffness and damping have to be at least 0");
  if ((command.stiffness_nm_rad.array() > abilities().max_stiffness_nm_rad).any())
    return hal::failure(ErrorCode::LimitExceeded, kWhere, "a stiffness above what the arm can");
  goal_rad_ = command.q_rad;
  last_command_ = command;
  answered_ = true;
  return {};
}

}  // namespace colift::sim_hal
