#pragma once

#include <span>
#include <vector>

#include "hal/config/range.hpp"
#include "perception/map/world_map.hpp"
#include "planner/motion/collision/distance_field.hpp"
#include "planner/motion/collision/exact_checker.hpp"
#include "planner/motion/collision/fast_checker.hpp"

namespace colift::planner {

/// What counts as an obstacle, and how far the arm keeps away from it.
struct SceneConfig {
  double margin_m = 0.01;
  bool hidden_is_obstacle = true;
  bool out_of_view_is_obstacle = false;
  double own_space_m = 0.5;
  double ground_clearance_m = 0.005;
  double partner_clearance_m = 0.12;

  template <class Visitor>
  void visit(Visitor& v) {
    v("margin_m", margin_m, hal::Range{0, 0.2}, "Distance that the arm keeps from obstacles (m).");
    v("hidden_is_obstacle", hidden_is_obstacle,
      "Whether the arm keeps out of space behind what was seen; the hand has a rule of its own for it.");
    v("out_of_view_is_obstacle", out_of_view_is_obstacle,
      "The same for space at which the camera does not look.");
    v("own_space_m", own_space_m, hal::Range{0, 2},
      "Horizontal distance from the robot's axis within which unseen space counts as free: whoever sets the "
      "robot up "
      "keeps it clear (m).");
    v("ground_clearance_m", ground_clearance_m, hal::Range{0, 0.2},
      "Distance that links keep from the ground (m).");
    v("partner_clearance_m", partner_clearance_m, hal::Range{0, 1},
      "Distance that arm and hand keep from the partner's hands and body (m).");
  }
};

/// Everything a motion must not touch, made once for a map: distance fields of scene and target, ground
/// plane, the partner's points. Immutable; any thread.
struct CollisionScene {
  DistanceField obstacles;      ///< Occupied cells, not the target: for wrist and hand.
  DistanceField arm_obstacles;  ///< The same and hidden cells as configured: for the links up to the forearm.
  DistanceField target;
  hal::Plane ground;
  std::vector<Eigen::Vector3f> carried_W;  ///< Target's cells as they stand before the lift (for Carrying).
  float carried_cell_m = 0.02f;
  SceneConfig config;
};

/// Cells with their middle nearer to the ground than this many cells, or below it, are the ground's.
inline constexpr double kGroundCells = 1.5;

/// `partner_points` keep the robot away from him; may be empty.
[[nodiscard]] CollisionScene make_collision_scene(const perception::WorldMap& map, const hal::Plane& ground,
                                                  std::span<const Eigen::Vector3f> partner_points,
                                                  const SceneConfig& config);

}  // namespace colift::planner
