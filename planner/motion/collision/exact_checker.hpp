#pragma once

#include <memory>

#include "hal/robot_model/robot_model.hpp"
#include "perception/map/world_map.hpp"
#include "planner/motion/collision/touch.hpp"

namespace colift::planner {

/// The exact judge: FCL primitives of the URDF against the OctoMap's octree and an octree of the target's
/// cells, ground and self. It knows what was measured only: no margins, no hidden space, no partner. Cells at
/// the ground are left to the ground plane, as in make_collision_scene(). Slow; every final path is checked
/// with it again.
class ExactChecker {
 public:
  /// Copies what it needs.
  ExactChecker(const hal::RobotModel& model, const perception::WorldMap& map, const hal::Plane& ground);
  ~ExactChecker();
  ExactChecker(ExactChecker&&) noexcept;
  void set_hand(const hal::HandPosture& hand);
  void allow(Contacts contacts);
  /// For Carrying, as FastChecker's: arm links are checked against the target where it is carried.
  void set_carry_origin(const hal::Pose& X_WH);
  [[nodiscard]] Touch what_touches(const hal::JointVector& q_rad);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace colift::planner
