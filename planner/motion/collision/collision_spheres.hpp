#pragma once

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
  std::vector<std::pair<int, int>> self_pairs;  ///< Links that can meet each other, the lower one first.
};

/// `excess_m`: how far a sphere may stand out of a link's surface. The round ends of cylinders, which other
/// links mostly cover, stand out farther, and so do boxes that would take over 32 spheres.
[[nodiscard]] SphereModel cover_with_spheres(const hal::RobotModel& model, double excess_m = 0.009);

/// The spheres of one shape, in the frame of its link. Each part of a regular division of the shape lies in a
/// sphere of its own.
void cover_shape(const hal::LinkShape& shape, double excess_m,
                 std::vector<std::pair<hal::Vec3, double>>& out);

/// The moving body of each link: 0 fixed to W, k carried by joint Ak. The hand's own joints do not count.
[[nodiscard]] std::vector<int> arm_body(const hal::RobotModel& model);

/// Whether two links are asked at all if they meet. Neighbours always do; arm links with one body between
/// them are kept apart by the maker's joint limits, while the simple shapes that stand for them (at the
/// wrist) are not; the hand's own joints are not planned.
[[nodiscard]] bool may_meet(const hal::RobotModel& model, const std::vector<int>& body, int a, int b);

}  // namespace colift::planner
