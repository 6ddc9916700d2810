#pragma once

#include "hal/robot_model/robot_model.hpp"
#include "planner/motion/trajectory/joint_path.hpp"
#include "planner/motion/trajectory/trajectory.hpp"

namespace colift::planner {

/// Greatest speed of the palm's origin along a trajectory (m/s), on a grid of 10 ms.
[[nodiscard]] double palm_speed_m_s(const hal::RobotModel& model, const Trajectory& trajectory);

/// make_trajectory() with the joints' velocities lowered until the palm is nowhere faster than `speed_m_s`.
/// Errors: as make_trajectory().
[[nodiscard]] hal::Result<Trajectory> make_slow_trajectory(const hal::RobotModel& model,
                                                           std::span<const hal::JointVector> path,
                                                           const MotionLimits& limits, double blend_rad,
                                                           double speed_m_s);

/// The same along a dense path whose corners are only those of its sampling (a straight line of the hand).
[[nodiscard]] hal::Result<Trajectory> make_slow_trajectory_along(const hal::RobotModel& model,
                                                                 std::span<const hal::JointVector> path,
                                                                 const MotionLimits& limits,
                                                                 double speed_m_s);

/// Joint positions along a trajectory, at most about `step_rad` apart in any joint, ends included.
[[nodiscard]] JointPath sampled(const Trajectory& trajectory, double step_rad);

}  // namespace colift::planner
