#pragma once

#include <memory>
#include <vector>

#include "hal/hand.hpp"
#include "hal/robot_model/robot_model.hpp"
#include "hal/types/geometry.hpp"
#include "hal/types/joints.hpp"
#include "planner/hand/hand_collision.hpp"
#include "planner/hand/hand_model.hpp"

namespace colift::control {

/// `where` of the error when a camera is not where its calibration says.
inline constexpr const char* kCameraOff = "calibration";

/// What seeing needs to know about the rig, beside the configuration.
struct RigView {
  const hal::RobotModel& model;
  const planner::HandModel& hand;
  std::shared_ptr<const planner::HandCollision> hand_tables;
  hal::Pose X_WC = hal::Pose::Identity();  ///< Of the first camera.
  std::vector<hal::Pose> X_WC_more = {};   ///< Of the others, in the order of hal::Robot::more_cameras.
};

/// Where the robot is when a frame is taken.
struct RobotPosture {
  hal::JointVector q_rad = hal::JointVector::Zero();
  hal::HandPosture hand;
};

}  // namespace colift::control
