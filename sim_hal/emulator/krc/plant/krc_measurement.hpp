#pragma once

#include "sim_hal/emulator/krc/plant/krc_motion.hpp"

namespace colift::sim_hal {

/// The tool's wrench that explains joint torques, x y z, rx ry rz about the tool, axes of W. Near a straight
/// arm directions without leverage come out as 0.
[[nodiscard]] Vector6 wrench_of(const hal::JointVector& tau_nm, const hal::ArmJacobian& J);

/// Fills everything that is measured, commanded or computed from the arm's model.
void fill_arm(KrcMeasurement& m, const KrcMotion& motion, const KrcPlantState& plant,
              const hal::ArmDynamics& dynamics, const hal::Pose& X_FT);

}  // namespace colift::sim_hal
