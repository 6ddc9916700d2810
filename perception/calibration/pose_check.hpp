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
  int min_points = 400;
  double reach_m = 0.08;
  int stride = 3;
  int iterations = 12;
  double min_arm_height_m = 0.08;
  double robust_m = 0.01;
  double min_direction_fraction = 0.05;
  double max_depth_step_m = 0.05;

  template <class Visitor>
  void visit(Visitor& v) {
    v("on", on, "Whether a run checks ground and arm against the calibration before anything moves.");
    v("max_tilt_deg", max_tilt_deg, hal::Range{0.1, 45}, "Max angle between the ground and level (deg).");
    v("max_height_m", max_height_m, hal::Range{0.001, 1},
      "Max depth of the ground below the robot's floor (m).");
    v("max_arm_m", max_arm_m, hal::Range{0.001, 0.5},
      "Max offset of the arm from its model, which is as coarse as the links' solids (m).");
    v("min_points", min_points, hal::Range{20, 100000},
      "Min number of pixels of the arm in view for its offset to be judged.");
    v.renamed("least_points", "min_points");
    v("reach_m", reach_m, hal::Range{0.01, 0.3}, "Max distance of the arm's points from the model (m).");
    v("stride", stride, hal::Range{1, 32}, "Every n-th pixel of every n-th row is used.");
    v("iterations", iterations, hal::Range{1, 1000}, "Max number of iterations of the fit of the offset.");
    v("min_arm_height_m", min_arm_height_m, hal::Range{0, 2},
      "Min height of the arm's points: what is lower is the floor or the base's foot (m).");
    v("robust_m", robust_m, hal::Range{0.0001, 1},
      "Residual beyond which a point counts linearly and not squared (m; Huber's weight).");
    v("min_direction_fraction", min_direction_fraction, hal::kFraction,
      "Min fraction of the points' normals along a direction for an offset in that direction.");
    v("max_depth_step_m", max_depth_step_m, hal::Range{0.001, 1},
      "Max depth difference around a pixel of the arm; at a silhouette it is larger (m).");
  }
};

/// What was seen of the camera's pose.
struct PoseCheck {
  bool good = true;
  std::string reason;  ///< One sentence with numbers, either way.
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
