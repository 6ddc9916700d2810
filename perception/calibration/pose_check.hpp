#pragma once

#include <optional>
#include <string>

#include "hal/config/range.hpp"
#include "hal/depth_camera.hpp"
#include "hal/robot_model/robot_model.hpp"
#include "perception/scene.hpp"

namespace colift::perception {

/// When a camera is not where its calibration says.
struct PoseCheckConfig {
  bool on = true;
  double max_tilt_deg = 2.0;
  double max_height_m = 0.04;
  double max_arm_m = 0.025;
  int least_points = 400;
  double reach_m = 0.08;

  template <class Visitor>
  void visit(Visitor& v) {
    v("on", on, "Whether a run looks if ground and arm are where they should be, before anything moves.");
    v("max_tilt_deg", max_tilt_deg, hal::Range{0.1, 45},
      "Greatest angle between the ground seen and level (deg).");
    v("max_height_m", max_height_m, hal::Range{0.001, 1},
      "How far below the robot's floor the ground may be seen (m).");
    v("max_arm_m", max_arm_m, hal::Range{0.001, 0.5},
      "How far beside its model the arm may be seen (m); the model is as coarse as the links' solids are.");
    v("least_points", least_points, hal::Range{20, 100000}, "Fewer points of the arm in view say nothing.");
    v("reach_m", reach_m, hal::Range{0.01, 0.3}, "Points so near to the model are taken for the arm's (m).");
  }
};

/// What was seen of the camera's pose.
struct PoseCheck {
  bool good = true;
  std::string because;  ///< One sentence with numbers, either way.
  double tilt_rad = 0.0;
  double height_m = 0.0;          ///< Of the ground seen, over the robot's floor.
  int arm_points = 0;             ///< 0: the arm is not in view.
  Vec3 arm_off_B = Vec3::Zero();  ///< By how much the arm is seen beside its model (m).
};

/// Is the ground level and not below the floor z = 0, and the arm where the model says? `frame`: depth with
/// the robot in it. The arm's offset is the shift that brings its points onto the model's surface, robustly;
/// a direction in which the visible part of the arm says nothing stays 0. A few ms.
[[nodiscard]] PoseCheck check_pose(const hal::DepthFrame& frame, const hal::Pose& X_BC,
                                   const std::optional<hal::Plane>& ground_B, const hal::RobotModel& robot,
                                   const hal::JointVector& q_rad, const hal::HandPosture& hand,
                                   const PoseCheckConfig& config);

}  // namespace colift::perception
