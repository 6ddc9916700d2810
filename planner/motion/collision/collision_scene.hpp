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
  double partner_contact_m = 0.17;
  int speck_distance_cells = 4;
  int min_obstacle_cells = 6;
  double max_carried_fall_m = 0.005;

  template <class Visitor>
  void visit(Visitor& v) {
    v("margin_m", margin_m, hal::Range{0, 0.2}, "Min distance of the arm from obstacles (m).");
    v("hidden_is_obstacle", hidden_is_obstacle,
      "Whether space hidden behind what was seen is an obstacle to the arm; the hand has limits of its own.");
    v("out_of_view_is_obstacle", out_of_view_is_obstacle, "The same for space outside of the camera's view.");
    v("own_space_m", own_space_m, hal::Range{0, 2},
      "Horizontal distance from the robot's axis within which unseen space counts as free; keep it clear "
      "(m).");
    v("ground_clearance_m", ground_clearance_m, hal::Range{0, 0.2},
      "Min distance of links from the ground (m).");
    v("partner_clearance_m", partner_clearance_m, hal::Range{0, 1},
      "Min distance of arm and hand from the partner's hands and body (m).");
    v("partner_contact_m", partner_contact_m, hal::Range{0, 1},
      "Distance beyond the partner clearance within which the carried object may touch the partner (m).");
    v("speck_distance_cells", speck_distance_cells, hal::Range{0, 20},
      "Max distance from the target of occupied cells that may be specks of its edges, in cells.");
    v("min_obstacle_cells", min_obstacle_cells, hal::Range{1, 1000},
      "Min number of connected cells of an obstacle so near to the target; fewer are specks.");
    v("max_carried_fall_m", max_carried_fall_m, hal::Range{0, 0.1},
      "Max downward motion of the carried object where it touches what it stands on (m).");
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

/// Keeps the ground's own measurements from being obstacles: they fill its cells and, by noise, the layer
/// above. Cells with their middle nearer to the ground than this many cells, or below it, are the ground's.
inline constexpr double kGroundCells = 1.5;

/// The scene without any partner.
[[nodiscard]] CollisionScene make_collision_scene(const perception::WorldMap& map, const hal::Plane& ground,
                                                  const SceneConfig& config);

/// The same with something that stands there since: `points` (W) keep the whole robot `clearance_m` away.
[[nodiscard]] CollisionScene with_obstacle(const CollisionScene& scene, const perception::CellGrid& grid,
                                           std::span<const Eigen::Vector3f> points, double clearance_m);

/// The same with him: `partner_points` (W) keep the robot away, and what of the target is at his hands may
/// touch him while both lift. Costs what his surroundings cost, not what the map does. `grid`: of the map
/// that the scene was made of.
[[nodiscard]] CollisionScene with_partner(const CollisionScene& scene, const perception::CellGrid& grid,
                                          std::span<const Eigen::Vector3f> partner_points);
/// Both at once.
[[nodiscard]] CollisionScene make_collision_scene(const perception::WorldMap& map, const hal::Plane& ground,
                                                  std::span<const Eigen::Vector3f> partner_points,
                                                  const SceneConfig& config);

}  // namespace colift::planner
