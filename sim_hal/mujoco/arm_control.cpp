#include "sim_hal/mujoco/arm_control.hpp"

#include <algorithm>

namespace colift::sim_hal {

ArmControl::ArmControl(const hal::JointVector& start_rad, const hal::JointVector& effort_nm)
    : effort_nm_(effort_nm), set_point_rad_(start_rad) {
  command_.q_rad = start_rad;
}

void ArmControl::command(const hal::ImpedanceCommand& command, int ticks) {
  command_ = command;
  ticks_left_ = std::max(ticks, 1);
  step_rad_ = (command.q_rad - set_point_rad_) / ticks_left_;
}

void ArmControl::hold() {
  for (int i = 0; i < hal::kArmJoints; ++i) {
    if (command_.stiffness_nm_rad[i] > 1.0)
      set_point_rad_[i] += command_.tau_superposed_nm[i] / command_.stiffness_nm_rad[i];
  }
  command_.tau_superposed_nm.setZero();
  command_.q_rad = set_point_rad_;
  ticks_left_ = 0;
}

hal::JointVector ArmControl::tick(const hal::JointVector& q_rad, const hal::JointVector& dq_rad_s,
                                  const hal::JointVector& bias_nm, const hal::JointVector& inertia) {
  if (ticks_left_ > 0) {
    set_point_rad_ = --ticks_left_ == 0 ? command_.q_rad : hal::JointVector(set_point_rad_ + step_rad_);
  }
  const auto damping = 2.0 * command_.damping_ratio.array() *
                       (command_.stiffness_nm_rad.array().max(0.0) * inertia.array()).sqrt();
  torque_nm_ =
      command_.stiffness_nm_rad.cwiseProduct(set_point_rad_ - q_rad) + bias_nm + command_.tau_superposed_nm;
  torque_nm_.array() -= damping * dq_rad_s.array();
  torque_nm_ = torque_nm_.cwiseMax(-effort_nm_).cwiseMin(effort_nm_);
  return torque_nm_;
}

}  // namespace colift::sim_hal
