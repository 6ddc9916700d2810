#pragma once

#include <memory>

#include "hal/robot_model/robot_model.hpp"
#include "perception/map/world_map.hpp"
#include "planner/motion/collision/collision_spheres.hpp"
#include "planner/motion/free_space.hpp"
#include "planner/motion/trajectory/joint_path.hpp"

namespace colift::bench {

/// What a textbook would do: OMPL's RRT-Connect and path simplifier with their defaults, states checked by
/// FCL's primitives against FCL's octree and against each other.
class StockPlanner {
 public:
  StockPlanner(const hal::RobotModel& model, const planner::SphereModel& pairs,
               const perception::WorldMap& map, const planner::JointBox& box);
  ~StockPlanner();

  struct Outcome {
    planner::JointPath path;  ///< Empty when none was found within `limit_s`.
    double plan_ms = 0.0, simplify_ms = 0.0;
  };
  /// `resolution`: OMPL's longest step between checked states as a part of the space's extent; its default is
  /// 0.01.
  [[nodiscard]] Outcome plan(const hal::JointVector& start, const hal::JointVector& goal, double limit_s,
                             double resolution);
  [[nodiscard]] bool is_free(const hal::JointVector& q_rad);
  [[nodiscard]] std::size_t checks() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace colift::bench
