#pragma once

#include "planner/motion/inverse_kinematics/arm_ik.hpp"
#include "planner/motion/trajectory/joint_path.hpp"

namespace colift::planner {

/// Moves the flange from X_WF straight by `shift_W` (m) without turning it, in steps of at most `step_m`,
/// starting from the joint position at the end of `path`, on the same branch of the inverse kinematics.
/// Appends one joint position per step. Returns how far it came (m): all of the way, or less when the joint
/// limits (less `margin_rad`), the reach or a jump of the arm (more than `max_turn_rad_per_m`) ends it.
double follow_line(const ArmGeometry& arm, const hal::Pose& X_WF, const hal::Vec3& shift_W, double step_m,
                   double margin_rad, double max_turn_rad_per_m, JointPath& path);

}  // namespace colift::planner
