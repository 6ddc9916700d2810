#pragma once

#include "sim_hal/emulator/krc/plant/krc_plant.hpp"

namespace colift::sim_hal {

/// A torque law about the present pose: tau = feed - K (q - q0) - D dq, q0 the pose that it was made for.
/// Gravity and Coriolis terms are compensated apart from it.
struct JointLaw {
  hal::JointVector feed_nm = hal::JointVector::Zero();
  hal::JointMatrix stiffness = hal::JointMatrix::Zero(), damping = hal::JointMatrix::Zero();
};

/// Joint impedance: K (q_d - q) + tau. The maker does not publish how the damping ratio becomes a damping;
/// here D = 2 d sqrt(K m), m the joint's own entry of the mass matrix.
[[nodiscard]] JointLaw joint_impedance(const KrcSetPoint& set_point, const hal::JointVector& q_rad,
                                       const hal::JointMatrix& M);

/// Cartesian impedance: J' (K_c (x_d - x) + F), damped with the mass that each direction of the tool feels.
/// The posture leans to q_d through the null space of J, whose torques move no force at the tool at rest.
[[nodiscard]] JointLaw cartesian_impedance(const KrcSetPoint& set_point, const hal::JointVector& q_rad,
                                           const hal::Pose& X_WT, const hal::ArmJacobian& J,
                                           const hal::JointMatrix& M);

/// From one frame to the other: translation and rotation vector, axes of W.
[[nodiscard]] Vector6 frame_difference(const hal::Pose& from, const hal::Pose& to);

}  // namespace colift::sim_hal
