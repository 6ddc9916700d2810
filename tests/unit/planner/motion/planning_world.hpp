#pragma once

#include <memory>
#include <vector>

#include "hal/robot_model/robot_model.hpp"
#include "perception/map/world_map.hpp"
#include "planner/grasp_candidate.hpp"
#include "planner/motion/collision/collision_scene.hpp"
#include "planner/motion/trajectory/trajectory.hpp"
#include "sim_hal/synthetic/shapes.hpp"

namespace colift::tests {

/// Hidden space does not count: the cameras saw what there is.
[[nodiscard]] planner::SceneConfig seen_everything();

/// A world of primitives, seen from all around by ideal cameras, as the planner knows it.
struct PlanningWorld {
  sim_hal::World truth;
  perception::WorldMap map;
  std::shared_ptr<const planner::CollisionScene> scene;
};
[[nodiscard]] PlanningWorld see_from_all_sides(const sim_hal::World& truth,
                                               const planner::SceneConfig& config = seen_everything());

/// The arm bent over itself with the hand before it, pointing to +x.
[[nodiscard]] hal::JointVector home_rad();

/// A table that stands on the floor with its middle at (x, y), turned by `yaw_rad`: a plate 25 mm thick on
/// four legs of 40 mm. `size`: along its own x, along its own y, height of the top.
struct TableAt {
  double x = 0.95, y = 0.0, yaw_rad = 0.0;
  hal::Vec3 size{0.5, 0.8, 0.45};
  sim_hal::Label label = sim_hal::Label::Target;
  static constexpr double kPlate = 0.025, kLeg = 0.04;
};
void add_table(sim_hal::World& world, const TableAt& table);
void add_floor(sim_hal::World& world);

/// A grasp with the given middle of the face between the fingers.
[[nodiscard]] planner::GraspCandidate grasp_at(const hal::Vec3& position, const hal::Vec3& approach,
                                               const hal::Vec3& closing, double width_m);
/// The grasp on the edge of a table's plate: the side whose outward normal is at `side_rad` (0, pi/2, pi,
/// 3 pi/2 in the table's frame), `along_m` from the side's middle.
[[nodiscard]] planner::GraspCandidate plate_grasp(const TableAt& table, double side_rad, double along_m);

/// How far the robot's own solids go into shapes of the world (m, 0 if they touch nothing), by points on the
/// surfaces and axes of the links' shapes against the true shapes; an independent judge. Shapes with label
/// `allowed` may be touched by links of the hand.
[[nodiscard]] double penetration_m(const hal::RobotModel& model, const hal::JointVector& q_rad,
                                   const sim_hal::World& world,
                                   sim_hal::Label allowed = sim_hal::Label::Nothing);

}  // namespace colift::tests
