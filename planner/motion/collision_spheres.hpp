#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "hal/robot_model/robot_model.hpp"

namespace colift::planner {

/// One sphere of the robot, fixed to a link.
struct LinkSphere {
  int link = 0;
  hal::Vec3 center_L = hal::Vec3::Zero();
  double radius_m = 0.0;
};

/// The robot as spheres that cover its collision shapes completely: what the spheres do not touch, the robot
/// does not touch. Generated from the model.
struct SphereModel {
  std::vector<LinkSphere> spheres;              ///< By link, links ascending.
  std::vector<std::pair<int, int>> self_pairs;  ///< Links that can meet each other (never neighbours).
};

/// `excess_m`: how far a sphere may stand out of a link's surface.
[[nodiscard]] SphereModel cover_with_spheres(const hal::RobotModel& model, double excess_m = 0.012);

}  // namespace colift::planner
