#include "sim_hal/emulator/krc/plant/krc_motion.hpp"

#include <algorithm>
#include <cmath>

#include "sim_hal/emulator/krc/plant/krc_control_law.hpp"

namespace colift::sim_hal {
namespace {

constexpr double kFade_s = 0.1;  // superposed torque after command mode

hal::Pose moved(const hal::Pose& X, const Vector6& by) {
  hal::Pose out = X;
  out.translation() += by.head<3>();
  const hal::Vec3 turn = by.tail<3>();
  if (const double angle = turn.norm(); angle > 1e-12)
    out.linear() = Eigen::AngleAxisd(angle, turn / angle).toRotationMatrix() * X.linear();
  return out;
}

}  // namespace

KrcMotion::KrcMotion(const hal::ArmDynamics& dynamics, const hal::Pose& X_FT, const KrcLimits& limits,
                     hal::Duration cycle)
    : dynamics_(dynamics), X_FT_(X_FT), limits_(limits), cycle_s_(hal::seconds(cycle)) {
  start_at(hal::JointVector::Zero());
}

void KrcMotion::start_at(const hal::JointVector& q_rad) {
  q_rad_ = q_krl_rad_ = q_received_rad_ = q_rad;
  X_WT_ = X_WT_krl_ = X_received_ = tool(q_rad);
  q_step_rad_.setZero();
  X_step_.setZero();
  set_point_.q_rad = q_rad_;
  set_point_.X_WT = X_WT_;
  use_program_gains();
}

void KrcMotion::set_strategy(FriControl control, const KrlStiffness& stiffness) {
  control_ = control;
  stiffness_ = stiffness;
  use_program_gains();
}

void KrcMotion::use_program_gains() {
  KrcSetPoint& s = set_point_;
  // between two sessions the arm stands in its joints, whatever the strategy is
  s.control = control_ == FriControl::Position ? FriControl::Position : FriControl::JointImpedance;
  s.stiffness_nm_rad.setConstant(stiffness_.axis_nm_rad);
  s.damping_ratio.setConstant(stiffness_.axis_damping);
  s.cart_stiffness << hal::Vec3::Constant(stiffness_.cart_n_m), hal::Vec3::Constant(stiffness_.cart_nm_rad);
  s.cart_damping_ratio.setConstant(stiffness_.cart_damping);
  s.tau_nm.setZero();
  s.wrench.setZero();
}

void KrcMotion::set_measured(const KrcPlantState& measured) {
  measured_ = measured;
  X_WT_measured_ = tool(measured.q_rad);
}

KrcJudgedAt KrcMotion::judged_at() const {
  KrcJudgedAt at;
  at.control = control_;
  at.q_rad = q_received_rad_;
  at.X_WT = X_received_;
  at.q_measured_rad = measured_.q_rad;
  at.X_WT_measured = X_WT_measured_;
  at.flags = flags_;
  at.since_s = cycle_s_ * (cycles_since_ + 1);
  at.safety_limits = safety_limits_;
  at.stiffness_nm_rad.setConstant(stiffness_.axis_nm_rad);
  at.cart_stiffness << hal::Vec3::Constant(stiffness_.cart_n_m), hal::Vec3::Constant(stiffness_.cart_nm_rad);
  return at;
}

void KrcMotion::enter(std::uint32_t flags, double safety_limits) {
  flags_ = flags;
  safety_limits_ = safety_limits;
  set_point_.control = control_;
  q_received_rad_ = q_rad_;
  // spring without tension: an arm that sags a little does not jump up
  X_WT_ = X_received_ = cartesian() ? X_WT_measured_ : tool(q_rad_);
  set_point_.X_WT = X_WT_;
  q_step_rad_.setZero();
  X_step_.setZero();
  cycles_since_ = 0;
}

void KrcMotion::follow(const KrcCommand& c) {
  const auto has = [&](std::uint32_t flag) { return (c.flags & flag) != 0; };
  KrcSetPoint& s = set_point_;
  const double cycles = cycles_since_ + 1;
  if (has(fri_flag::kJointPosition)) {
    const hal::JointVector q = joints_of(c.q_rad);
    q_step_rad_ = (q - q_received_rad_) / cycles;
    q_received_rad_ = q;
    s.q_rad = q;
  }
  if (has(fri_flag::kCartPosition)) {
    const hal::Pose X = *frame_of(c.X_WT);
    X_step_ = frame_difference(X_received_, X) / cycles;
    X_received_ = X_WT_ = s.X_WT = X;
  }
  if (has(fri_flag::kJointTorque)) s.tau_nm = joints_of(c.tau_nm);
  if (has(fri_flag::kJointStiffness)) s.stiffness_nm_rad = joints_of(c.stiffness_nm_rad);
  if (has(fri_flag::kJointDamping)) s.damping_ratio = joints_of(c.damping);
  if (has(fri_flag::kTcpWrench)) s.wrench = usual_order(c.wrench);
  if (has(fri_flag::kCartStiffness)) s.cart_stiffness = usual_order(c.cart_stiffness);
  if (has(fri_flag::kCartDamping)) s.cart_damping_ratio = usual_order(c.cart_damping);
  cycles_since_ = 0;
  repeat();
}

void KrcMotion::extrapolate() {
  ++cycles_since_;
  set_point_.q_rad =
      (set_point_.q_rad + q_step_rad_).cwiseMax(-limits_.position_rad).cwiseMin(limits_.position_rad);
  set_point_.X_WT = X_WT_ = moved(set_point_.X_WT, X_step_);
  repeat();
}

void KrcMotion::repeat() {
  // nobody commands joints in Cartesian impedance: the sum that is told is where they are
  q_rad_ = cartesian() ? measured_.q_rad : set_point_.q_rad;
  if (!cartesian()) X_WT_ = tool(q_rad_);
}

void KrcMotion::leave() {
  if (cartesian()) {
    q_rad_ = measured_.q_rad;
    q_step_rad_ = cycle_s_ * measured_.dq_rad_s;
    set_point_.tau_nm.setZero();
  }
  tau_fade_nm_ = set_point_.tau_nm;
  use_program_gains();
  set_point_.tau_nm = tau_fade_nm_;
  set_point_.q_rad = q_rad_;
}

bool KrcMotion::come_to_rest() {
  const hal::JointVector brake = limits_.acceleration_rad_s2 * cycle_s_ * cycle_s_;
  bool rests = true;
  for (int i = 0; i < hal::kArmJoints; ++i) {
    q_step_rad_[i] = std::copysign(std::max(std::abs(q_step_rad_[i]) - brake[i], 0.0), q_step_rad_[i]);
    rests = rests && q_step_rad_[i] == 0.0;
    const double fade = std::abs(tau_fade_nm_[i]) * cycle_s_ / kFade_s;
    double& tau = set_point_.tau_nm[i];
    tau = std::abs(tau) <= fade + 1e-9 ? 0.0 : tau - std::copysign(fade, tau);
    rests = rests && tau == 0.0;
  }
  q_rad_ = (q_rad_ + q_step_rad_).cwiseMax(-limits_.position_rad).cwiseMin(limits_.position_rad);
  q_received_rad_ = q_rad_;
  set_point_.q_rad = q_rad_;
  X_WT_ = X_received_ = tool(q_rad_);
  return rests;
}

}  // namespace colift::sim_hal
