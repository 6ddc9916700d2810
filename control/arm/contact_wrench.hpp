#pragma once

#include "hal/robot_model/robot_model.hpp"
#include "hal/types/geometry.hpp"
#include "hal/types/joints.hpp"

namespace colift::control {

/// Standard deviations of what makes external joint torques although nothing touches the arm.
struct TorqueErrors {
  double joint_nm = 0.0;  ///< Of each joint's torque sensor.
  double tool_kg = 0.0;   ///< Of the tool's mass.
};

/// The most probable wrench of a contact on the hand about the palm, in W, where contacts are small and
/// torques err: the maximum of the posterior of F and an unknown mass m with tau = J(q)^T F + m (J(q) -
/// J(q0))^T g + errors, and a normal prior of 30 N and 3 N m on F. `tau_nm`: external joint torques less
/// those at the tare's posture q0; `tare_rise_m`: palm_rise() there. Where the arm feels well this is
/// palm_wrench(); near a singular posture, where errors alone would be a large wrench, it is rather too
/// small. For deciding whether there is a contact, not for weighing a load. Allocation-free.
[[nodiscard]] hal::Wrench contact_wrench(const hal::RobotModel& model, const hal::JointVector& q_rad,
                                         const hal::JointVector& tare_rise_m, const hal::JointVector& tau_nm,
                                         const TorqueErrors& errors);

/// How far each joint raises the palm (m/rad).
[[nodiscard]] hal::JointVector palm_rise(const hal::RobotModel& model, const hal::JointVector& q_rad);

}  // namespace colift::control
