#include "sim_hal/emulator/krc/plant/krc_light_plant.hpp"

#include <algorithm>
#include <cmath>

#include "hal/types/symmetric.hpp"
#include "sim_hal/emulator/krc/plant/krc_control_law.hpp"

namespace colift::sim_hal {
namespace {

constexpr hal::Duration kTick = std::chrono::milliseconds(1);
constexpr double kTick_s = 0.001;
constexpr double kFollows_s = 0.004;  // lag of position control
constexpr double kStops_rad = 0.05;   // the mechanical stops lie that far behind the limits
constexpr double kSlow_rad_s = 0.01;  // below it friction is viscous

// ISIR's model of the arm
hal::JointVector coulomb_nm() {
  hal::JointVector f;
  f << 1, 1, 1, 1, 0.4, 0.1, 0.1;
  return f;
}
hal::JointVector viscous_nms() {
  hal::JointVector f;
  f << 0.2, 0.18, 0.1, 0.15, 0.12, 0.1, 0.1;
  return f;
}

}  // namespace

LightPlant::LightPlant(const hal::ArmDynamics& dynamics, const LightPlantConfig& config)
    : dynamics_(dynamics), config_(config), q_now_rad_(config.start_rad) {
  state_.q_rad = config.start_rad;
  state_.tau_nm = dynamics_.gravity_nm(state_.q_rad);
  set_point_.q_rad = config.start_rad;
}

hal::Result<> LightPlant::set_cycle(hal::Duration cycle) {
  ticks_ = std::max(static_cast<int>(cycle / kTick), 1);
  return {};
}

void LightPlant::command(const KrcSetPoint& set_point) {
  set_point_ = set_point;
  ticks_left_ = ticks_;
}

void LightPlant::set_brakes(bool closed) {
  brakes_ = closed;
  if (closed) state_.dq_rad_s.setZero();
}

void LightPlant::advance(hal::Duration by) {
  for (auto ticks = by / kTick; ticks > 0; --ticks) tick();
}

void LightPlant::tick() {
  if (ticks_left_ > 0) {
    q_now_rad_ += (set_point_.q_rad - q_now_rad_) / ticks_left_;
    --ticks_left_;
  }
  const hal::JointVector before_rad_s = state_.dq_rad_s;
  const hal::JointMatrix M = dynamics_.mass_matrix(state_.q_rad);
  const hal::ArmJacobian J = dynamics_.jacobian(state_.q_rad);
  const hal::JointVector push_nm = J.transpose() * push_;

  if (brakes_) {
    q_now_rad_ = state_.q_rad;
    state_.dq_rad_s.setZero();
  } else if (set_point_.control == FriControl::Position) {
    const hal::JointVector reach = limits_.velocity_rad_s * kTick_s;
    const hal::JointVector step = ((q_now_rad_ - state_.q_rad) * (1.0 - std::exp(-kTick_s / kFollows_s)))
                                      .cwiseMax(-reach)
                                      .cwiseMin(reach);
    state_.dq_rad_s = step / kTick_s;
  } else {
    KrcSetPoint now = set_point_;
    now.q_rad = q_now_rad_;
    JointLaw law;
    if (now.control == FriControl::CartesianImpedance)
      law = cartesian_impedance(now, state_.q_rad, dynamics_.flange(state_.q_rad), J, M);
    else if (now.control == FriControl::JointImpedance)
      law = joint_impedance(now, state_.q_rad, M);
    if (config_.friction) {
      law.damping.diagonal() += viscous_nms();
      law.damping.diagonal().array() += coulomb_nm().array() / before_rad_s.array().abs().max(kSlow_rad_s);
    }
    // both spring and damper at the end of the step: no gain can make it ring
    const hal::JointMatrix A = M + kTick_s * law.damping + kTick_s * kTick_s * law.stiffness;
    state_.dq_rad_s = hal::solve_small_symmetric(A, M * before_rad_s + kTick_s * (law.feed_nm + push_nm));
  }
  state_.q_rad += kTick_s * state_.dq_rad_s;
  for (int i = 0; i < hal::kArmJoints; ++i) {
    const double stop = limits_.position_rad[i] + kStops_rad;
    if (std::abs(state_.q_rad[i]) <= stop) continue;
    state_.q_rad[i] = std::clamp(state_.q_rad[i], -stop, stop);
    state_.dq_rad_s[i] = 0.0;
  }
  state_.tau_external_nm = push_nm;
  state_.tau_nm =
      dynamics_.torque_nm(state_.q_rad, state_.dq_rad_s, (state_.dq_rad_s - before_rad_s) / kTick_s) -
      push_nm;
}

}  // namespace colift::sim_hal
