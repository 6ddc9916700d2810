#pragma once

#include <cmath>
#include <cstdint>
#include <functional>
#include <string>

#include "control/config/config.hpp"
#include "control/session/perception_session.hpp"
#include "control/test_lift/test_lift.hpp"
#include "hal/types/geometry.hpp"
#include "hal/types/result.hpp"
#include "planner/motion/motion_planner.hpp"
#include "sim_hal/scenario/scenario.hpp"

namespace colift::experiments {

/// One grasp and lift in a world of its own, and how good it truly was. Angles in degrees, SI units else.
struct DirectLift {
  bool held = false;           ///< The hand closed on the object and every finger is stopped by it.
  bool lifted = false;         ///< ... and it was still held at the end of the time at the top.
  std::string reason;          ///< Why not.
  double tilt_deg = NAN;       ///< Mean at the top.
  double most_tilt_deg = 0.0;  ///< Largest since the hand closed.
  double share_robot = NAN;    ///< The robot's part of the vertical force, mean at the top.
  double robot_n = NAN;        ///< That force.
  double height_m = NAN;       ///< Of the centre of gravity.
  double slip_m = NAN;         ///< Largest motion in the hand since it closed.
  bool hit_something = false;
  /// What the arm's external torques said at the top, mean: wrench on the hand about the palm's origin, and
  /// where that was (W).
  hal::Wrench measured;
  hal::Vec3 palm_W = hal::Vec3::Zero();
};

/// Who looks on: asked with every frame of the scenario's camera from the closing of the hand to the end.
/// While the arm raises, his answer is how it goes on (slowly: config.task.slow_fraction).
enum class LiftPart { Before, Raising, Top };
using LiftObserver = std::function<control::Raise(hal::DepthFrame, const control::RobotPosture&, LiftPart)>;

/// Carries out a grasp that was decided elsewhere: the arm starts at the pre-grasp of `plan`, goes straight
/// in, closes, waits until the partner of the scenario holds (he is there from the start), lifts by
/// config.task.lift_height_m, holds for config.task.hold_s. Without an eye no camera runs, so nothing ends a
/// lift that goes wrong: its tilt and slip are measured to the end. Same arguments, same bits.
[[nodiscard]] hal::Result<DirectLift> lift_directly(sim_hal::Scenario scenario,
                                                    const planner::MotionPlan& plan,
                                                    const control::Config& config, std::uint64_t seed,
                                                    const LiftObserver& eye = {});

}  // namespace colift::experiments
