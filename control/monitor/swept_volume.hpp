#pragma once

#include <utility>
#include <vector>

#include "hal/robot_model/robot_model.hpp"
#include "perception/bodies/body_distance.hpp"
#include "planner/motion/trajectory/trajectory.hpp"

namespace colift::control {

/// The moving links of the arm as spheres, in one posture or along a trajectory. Spheres stand out of a
/// link's surface by up to 3 cm. Keeps its buffers; one thread.
class SweptVolume {
 public:
  explicit SweptVolume(const hal::RobotModel& model);

  /// Adds the spheres of one posture.
  void add_links(const hal::JointVector& q_rad, const hal::HandPosture& hand, perception::SphereSet& out);
  /// Adds those of postures along a trajectory between two times (s), both included.
  void add_path(const planner::Trajectory& trajectory, double from_s, double to_s,
                const hal::HandPosture& hand, perception::SphereSet& out);

 private:
  hal::RobotModel model_;
  std::vector<std::vector<std::pair<hal::Vec3, double>>> spheres_;  // by link: centre in it, radius
  std::vector<hal::Pose> X_WL_;
};

}  // namespace colift::control
