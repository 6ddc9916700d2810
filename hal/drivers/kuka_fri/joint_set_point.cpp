#include "hal/drivers/kuka_fri/joint_set_point.hpp"

#include <algorithm>
#include <cmath>

#include "hal/guards/braking_law.hpp"

namespace colift::hal {
namespace {

constexpr double kRounding = 1e-6;    // relative: a float at its limit is not beyond it
constexpr double kWalk_rad_s = 0.2;   // of the offset
constexpr double kWalk_rad_s2 = 2.0;  // added to what the user's own commands accelerate with
constexpr double kInTransit_rad = 2e-5;
constexpr double kStart_rad = 1e-3;  // a first command this near to the measured pose is there
// Of what torque and stiffness explain: their errors, and no more than a loaded arm can hang.
constexpr double kExplains = 1.3, kExplains_rad = 5e-4, kMaxHeld_rad = 0.1, kSoftest_nm_rad = 10.0;
// A load that shows in both, and how much alike both patterns are (cosine): friction turns them a little.
constexpr double kMinOff_rad = 3e-3, kMinTorque_nm = 3.0, kMinCosine = 0.8;

}  // namespace

FriJoints JointSetPoint::followed(const FriMeasurement& m) {
  FriJoints sum{};
  for (std::size_t i = 0; i < sum.size(); ++i) sum[i] = m.q_commanded_rad[i] + m.q_commanded_fri_rad[i];
  return sum;
}

JointVector JointSetPoint::joints(const FriJoints& q) {
  JointVector v;
  for (int i = 0; i < kArmJoints; ++i) v[i] = static_cast<double>(q[static_cast<std::size_t>(i)]);
  return v;
}

bool JointSetPoint::pulls_backwards(const JointVector& off_rad, const JointVector& tau_nm) {
  const double off = off_rad.norm(), tau = tau_nm.norm();
  return off > kMinOff_rad && tau > kMinTorque_nm && off_rad.dot(tau_nm) < -kMinCosine * off * tau;
}

bool JointSetPoint::explained(const JointVector& off_rad, const JointVector& tau_nm) {
  return pulls_backwards(-off_rad, tau_nm);
}

void JointSetPoint::send(const JointVector& q_rad) {
  for (int i = 0; i < kArmJoints; ++i) wire_[static_cast<std::size_t>(i)] = static_cast<float>(q_rad[i]);
  q_ = q_rad;
}

void JointSetPoint::mirror(const FriJoints& followed) {
  wire_ = followed;
  q_ = goal_ = joints(followed);
  step_.setZero();
  release();
  first_at_.reset();
  bridged_ = false;
}

void JointSetPoint::release() {
  offset_.setZero();
  doffset_.setZero();
  held_.setZero();
  load_nm_.setZero();
}

void JointSetPoint::hold_load() {
  for (int i = 0; i < kArmJoints; ++i) {
    held_[i] = 0.0;
    if (start_stiffness_[i] < kSoftest_nm_rad) continue;
    // a spring that a torque stretches: the set point is on the other side
    const double explained = -start_load_nm_[i] / start_stiffness_[i];
    if (explained * offset_[i] > 0.0)
      held_[i] = std::copysign(
          std::min({std::abs(offset_[i]), kExplains * std::abs(explained) + kExplains_rad, kMaxHeld_rad}),
          offset_[i]);
  }
  load_nm_ = held_.cwiseProduct(start_stiffness_);
}

void JointSetPoint::set_stiffness(const JointVector& stiffness_nm_rad) {
  for (int i = 0; i < kArmJoints; ++i)
    if (load_nm_[i] != 0.0 && stiffness_nm_rad[i] > kSoftest_nm_rad)
      held_[i] = std::clamp(load_nm_[i] / stiffness_nm_rad[i], -kMaxHeld_rad, kMaxHeld_rad);
}

void JointSetPoint::restart(const FriJoints& followed) {
  mirror(followed);
}

void JointSetPoint::expect_first(const JointVector& measured_rad, const JointVector& load_nm,
                                 const JointVector& stiffness_nm_rad) {
  start_load_nm_ = load_nm;
  start_stiffness_ = stiffness_nm_rad;
  if (first_at_) {
    first_at_ = measured_rad;
    return;
  }
  first_at_ = measured_rad;
  goal_ = q_;
  step_.setZero();
  release();
  bridged_ = false;
}

bool JointSetPoint::bridge(const FriJoints& followed, int cycles) {
  const JointVector at = joints(followed);
  if ((at - q_).cwiseAbs().maxCoeff() < kInTransit_rad) return false;
  for (int i = 0; i < kArmJoints; ++i) {
    const double way = step_[i] * cycles, gone = at[i] - q_[i];
    if (gone < std::min(way, 0.0) - kInTransit_rad || gone > std::max(way, 0.0) + kInTransit_rad)
      return false;
  }
  wire_ = followed;
  q_ = at;
  bridged_ = true;
  return true;
}

FriLimit JointSetPoint::command(const JointVector& q_rad, int steps, double period_s, double safety_limits) {
  using What = FriLimit::What;
  const double part = safety_limits > 0.0 ? safety_limits : 1.0;
  for (int i = 0; i < kArmJoints; ++i) {
    const auto axis = static_cast<std::uint8_t>(i);
    if (!std::isfinite(q_rad[i])) return {What::NotFinite, axis, q_rad[i], 0.0};
    if (std::abs(q_rad[i]) > limits_.limit_rad[i] * (1.0 + kRounding))
      return {What::Position, axis, q_rad[i], limits_.limit_rad[i]};
    const double step = limits_.velocity_rad_s[i] * part * period_s;
    if (first_at_) {
      const double off = std::min(std::abs(q_rad[i] - (*first_at_)[i]), std::abs(q_rad[i] - q_[i]));
      if (off > std::max(kStart_rad, step)) return {What::Start, axis, off, std::max(kStart_rad, step)};
    } else if (const double by = std::abs(q_rad[i] - goal_[i]); by > steps * step * (1.0 + 1e-4)) {
      return {What::Step, axis, by, steps * step};
    }
  }
  if (first_at_) {
    offset_ = q_ - q_rad;
    doffset_.setZero();
    hold_load();
    first_at_.reset();
    // nearer than one step from rest: there at once
    const double at_once = limits_.acceleration_rad_s2 * period_s * period_s;
    if ((offset_ - held_).cwiseAbs().maxCoeff() <= at_once) offset_ = held_;
  } else if (bridged_) {
    offset_ = q_ + step_ - q_rad;
    doffset_.setZero();
  } else {
    ramp(period_s);
  }
  bridged_ = false;
  goal_ = q_rad;
  JointVector next = goal_;
  if (!offset_.isZero()) next = (goal_ + offset_).cwiseMax(-limits_.limit_rad).cwiseMin(limits_.limit_rad);
  step_ = next - q_;
  send(next);
  return {};
}

void JointSetPoint::ramp(double period_s) {
  if (offset_ == held_) return;
  for (int i = 0; i < kArmJoints; ++i) {
    const double off = offset_[i] - held_[i];
    if (off == 0.0) continue;
    const double far = std::abs(off), side = off > 0.0 ? 1.0 : -1.0;
    const double speed = std::min(kWalk_rad_s, stoppable_speed(far, period_s, kWalk_rad_s2));
    const double change = kWalk_rad_s2 * period_s;
    doffset_[i] = std::clamp(-side * speed, doffset_[i] - change, doffset_[i] + change);
    const double step = doffset_[i] * period_s;
    if (far < 1e-7 || (step * side < 0.0 && std::abs(step) >= far)) {
      offset_[i] = held_[i];
      doffset_[i] = 0.0;
    } else {
      offset_[i] += step;
    }
  }
}

void JointSetPoint::repeat() {
  step_.setZero();
  doffset_.setZero();
  bridged_ = false;
}

void JointSetPoint::brake(double period_s) {
  first_at_.reset();
  JointVector next = q_;
  for (int i = 0; i < kArmJoints; ++i) {
    const JointBounds bounds{-limits_.limit_rad[i], limits_.limit_rad[i], limits_.velocity_rad_s[i],
                             limits_.acceleration_rad_s2};
    step_[i] = period_s * braking_velocity(q_[i], step_[i] / period_s, period_s, bounds);
    next[i] += step_[i];
  }
  if (!step_.isZero()) send(next);
  goal_ = q_;
  release();
  bridged_ = false;
}

}  // namespace colift::hal
