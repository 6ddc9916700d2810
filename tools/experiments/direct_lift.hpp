#pragma once

#include <cmath>
#include <cstdint>
#include <string>

#include "control/config.hpp"
#include "hal/types/geometry.hpp"
#include "hal/types/result.hpp"
#include "planner/motion/motion_planner.hpp"
#include "sim_hal/scenario/scenario.hpp"

namespace colift::experiments {

/// One grasp and lift in a world of its own, and how good it truly was. Angles in degrees, SI units else.
struct DirectLift {
  bool held = false;         ///< The hand closed on the object and every finger is stopped by it.
  bool lifted = false;       ///< ... and it was still held at the end of the time at the top.
  std::string because;       ///< Why not.
  double tilt_deg = NAN;     ///< Mean at the top.
  double share_robot = NAN;  ///< The robot's part of the vertical force, mean at the top.
  double robot_n = NAN;      ///< That force.
  double height_m = NAN;     ///< Of the centre of gravity.
  double slip_m = NAN;       ///< Largest motion in the hand since it closed.
  bool hit_something = false;
  /// What the arm's external torques said at the top, mean: wrench on the hand about the palm's origin, and
  /// where that was (W).
  hal::Wrench felt;
  hal::Vec3 palm_W = hal::Vec3::Zero();
};

/// Carries out a grasp that was decided elsewhere: the arm starts at the pre-grasp of `plan`, goes straight
/// in, closes, waits until the partner of the scenario holds (he is there from the start), lifts by
/// config.task.lift_height_m, holds for config.task.hold_s. No camera, so nothing ends a lift that goes
/// wrong: its tilt and slip are measured to the end. Same arguments, same bits.
[[nodiscard]] hal::Result<DirectLift> lift_directly(sim_hal::Scenario scenario,
                                                    const planner::MotionPlan& plan,
                                                    const control::Config& config, std::uint64_t seed);

}  // namespace colift::experiments
