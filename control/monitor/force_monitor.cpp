#include "control/monitor/force_monitor.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "control/lift/load_estimator.hpp"

namespace colift::control {
namespace {

// after a trajectory the springs of the arm swing out; what is felt meanwhile is no zero

double blend(double dt_s, double time_s) {
  return time_s > 0.0 ? 1.0 - std::exp(-dt_s / time_s) : 1.0;
}

}  // namespace

ForceMonitor::ForceMonitor(const hal::RobotModel& model, const ForceMonitorConfig& config)
    : model_(&model), config_(config) {}

void ForceMonitor::expect(HandLoad load) {
  load_ = load;
}

void ForceMonitor::clear() {
  finding_ = {};
  armed_ = false;
}

const ForceLimits* force_limits(const ForceMonitorConfig& config, HandLoad load) {
  switch (load) {
    case HandLoad::Closing:
      return &config.closing;
    case HandLoad::Carried:
      return &config.carried;
    case HandLoad::Lowering:
      return &config.lowering;
    case HandLoad::Empty:
      break;
  }
  return nullptr;
}

ForceFinding ForceMonitor::judge(const hal::JointVector& tau_nm) const {
  using Kind = ForceFinding::Kind;
  ForceFinding worst;
  double excess = 1.0;
  const auto compare = [&](Kind kind, double measured, double limit, int joint = 0) {
    if (measured <= excess * limit) return;
    excess = measured / limit;
    worst = {kind, measured, limit, felt_.force, joint, load_};
  };
  const double sideways = felt_.force.head<2>().norm(), up = felt_.force.z();
  const ForceLimits* limits = force_limits(config_, load_);
  if (!limits) {
    compare(Kind::Sideways, sideways, config_.rest_n);
    compare(Kind::Up, up, config_.rest_n);
    compare(Kind::Down, -up, config_.rest_n);
    return worst;
  }
  const ForceLimits& limit = *limits;
  compare(Kind::Sideways, sideways, limit.sideways_n);
  compare(Kind::Up, up, limit.up_n);
  compare(Kind::Down, -up, limit.down_n);
  compare(Kind::Torque, felt_.torque.norm(), limit.torque_nm);
  for (int i = 0; i < hal::kArmJoints; ++i) compare(Kind::Joint, std::abs(tau_nm[i]), config_.joint_nm, i);
  return worst;
}

void ForceMonitor::update(const hal::ArmState& state, double dt_s, bool moves_alone, bool in_contact) {
  if (!config_.on || dt_s <= 0.0 || !state.q_rad.allFinite() || !state.tau_external_nm.allFinite()) return;
  if (!zero_known_) zero_nm_ = state.tau_external_nm;
  zero_known_ = true;
  moved_s_ = moves_alone ? config_.settle_s : std::max(0.0, moved_s_ - dt_s);
  const bool settling = load_ == HandLoad::Empty && moved_s_ > 0.0;
  // slow enough that who leans on the arm is no part of its zero soon
  const double part =
      settling ? blend(dt_s, 0.1 * config_.rest_filter_s) : blend(dt_s, config_.rest_filter_s);
  if (load_ == HandLoad::Empty && quiet_ && !in_contact)
    zero_nm_ += part * (state.tau_external_nm - zero_nm_);

  const hal::JointVector tau = state.tau_external_nm - zero_nm_;
  const hal::Wrench now = palm_wrench(*model_, state.q_rad, tau);
  const double fast = blend(dt_s, config_.filter_s);
  felt_.force += fast * (now.force - felt_.force);
  felt_.torque += fast * (now.torque - felt_.torque);
  if (settling && !in_contact) {
    quiet_ = true;
    return;
  }
  const ForceFinding found = judge(tau);
  quiet_ = !found;
  if (!armed_) armed_ = !found || found.measured < config_.rearm_fraction * found.limit;
  if (armed_ && !finding_ && found) finding_ = found;
}

std::string describe(const ForceFinding& f) {
  using Kind = ForceFinding::Kind;
  switch (f.kind) {
    case Kind::None:
      return {};
    case Kind::Sideways:
      return fmt::format("{:.0f} N push the hand sideways (limit {:.0f} N)", f.measured, f.limit);
    case Kind::Up:
      return fmt::format("{:.0f} N push the hand up (limit {:.0f} N)", f.measured, f.limit);
    case Kind::Down:
      return fmt::format("{:.0f} N pull the hand down (limit {:.0f} N)", f.measured, f.limit);
    case Kind::Torque:
      return fmt::format("{:.0f} N m turn the hand (limit {:.0f} N m)", f.measured, f.limit);
    case Kind::Joint:
      return fmt::format("{:.0f} N m of external torque in A{} (limit {:.0f} N m)", f.measured, f.joint + 1,
                         f.limit);
  }
  return {};
}

}  // namespace colift::control
