// Collision worlds that no room looks like (safety-and-faults, row 10).

#include "control/session/map_check.hpp"

#include <octomap/octomap.h>

#include <catch2/catch.hpp>
#include <cmath>
#include <ctime>

#include "planner/motion/motion_planner.hpp"
#include "sim_hal/synthetic/hash_random.hpp"
#include "sim_hal/synthetic/ray_caster.hpp"

using namespace colift;
using control::map_fault;
using hal::Vec3;
using perception::CellState;
using perception::WorldMap;

namespace {

/// A box on the floor before the arm, seen from beside it.
struct Room {
  perception::OrganisedCloud cloud;

  explicit Room(double noise_part = 0.0) {
    sim_hal::World world;
    world.shapes.push_back(sim_hal::half_space(Vec3::Zero(), Vec3::UnitZ(), sim_hal::Label::Ground));
    world.shapes.push_back(sim_hal::box({0.9, 0, 0.2}, {0.4, 0.4, 0.4}, 0.3, sim_hal::Label::Clutter));
    const hal::Pose X_WC = sim_hal::look_at({2.2, -0.9, 1.4}, {0.7, 0, 0.3});
    hal::DepthFrame frame;
    frame.depth_m = sim_hal::cast_rays(world, frame.intrinsics, X_WC).depth_m;
    for (std::size_t i = 0; i < frame.depth_m.size(); ++i)
      if (sim_hal::unit(sim_hal::hash(1, 5, i)) < noise_part)
        frame.depth_m[i] = static_cast<float>(0.6 + 2.6 * sim_hal::unit(sim_hal::hash(2, 5, i)));
    cloud = perception::deproject(frame, X_WC);
  }
  [[nodiscard]] WorldMap map() const {
    WorldMap m({});
    m.insert(cloud, {});
    return m;
  }
};

/// A map whose every cell is occupied.
WorldMap full_map() {
  perception::WorldMapConfig config;
  config.cell_m = 0.05;
  octomap::OcTree tree(config.cell_m);
  const WorldMap empty(config);
  const auto& grid = empty.grid();
  for (int z = 0; z < grid.nz; ++z)
    for (int y = 0; y < grid.ny; ++y)
      for (int x = 0; x < grid.nx; ++x) {
        const Vec3 p = grid.middle(x, y, z);
        tree.updateNode(
            octomap::point3d(static_cast<float>(p.x()), static_cast<float>(p.y()), static_cast<float>(p.z())),
            true, true);
      }
  tree.updateInnerOccupancy();
  auto map = WorldMap::from_tree(tree, config);
  if (!map) FAIL(map.error().text());
  return std::move(*map);
}

}  // namespace

TEST_CASE("the map of a room as it was seen is believed, also with noise in it", "[map][faults]") {
  for (const double noise : {0.0, 0.05, 0.3}) {
    const Room room(noise);
    INFO(noise);
    CHECK_FALSE(map_fault(room.map(), room.cloud));
  }
}

TEST_CASE("a map that is all occupied, or empty where the camera sees a room, is not planned in",
          "[map][faults]") {
  const Room room;
  const auto full = map_fault(full_map(), room.cloud);
  REQUIRE(full);
  CHECK_THAT(*full, Catch::Contains("full") && Catch::Contains("100 %"));

  const auto unknown = map_fault(WorldMap({}), room.cloud);
  REQUIRE(unknown);
  CHECK_THAT(*unknown, Catch::Contains("too empty") && Catch::Contains("holds 0 %"));
  WorldMap freed = room.map();
  freed.carve({Vec3(-5, -5, -5), Vec3(5, 5, 5)});
  CHECK(map_fault(freed, room.cloud));

  // the map of another view: nothing of it is where the camera sees it
  perception::OrganisedCloud shifted = room.cloud;
  for (float& z : shifted.z) z += 0.25f;
  CHECK(map_fault(room.map(), shifted));
}

TEST_CASE("in a map full of noise the planner comes to an end: a way that touches nothing of it, or why not",
          "[map][faults]") {
  const Room room(0.6);
  WorldMap map({});
  map.insert(room.cloud, {});
  CHECK(map.occupied_cells() > 5000);
  planner::PlannerConfig config;
  config.scene.hidden_is_obstacle = false;
  planner::MotionPlanner planner(hal::built_in_robot(), planner::HandModel{}, config, 1);
  hal::JointVector home, goal;
  home << 0, -0.5, 0, 1.8, 0, -0.6, 0;
  goal << 1.2, 0.4, 0, 1.2, 0, 0.6, 0;
  map.carve_robot(hal::built_in_robot(), home, {});
  map.carve_robot(hal::built_in_robot(), goal, {});
  planner.set_scene(std::make_shared<planner::CollisionScene>(
                        planner::make_collision_scene(map, hal::Plane{Vec3::UnitZ(), 0.0}, {}, config.scene)),
                    map, Vec3::UnitZ());
  const std::clock_t began = std::clock();
  const auto way = planner.plan_to(home, goal);
  // its search is bounded by work, not by time: a generous bound that only a hang misses
  CHECK(static_cast<double>(std::clock() - began) / CLOCKS_PER_SEC < 60.0 * config.planning_budget_s);
  INFO((way ? "a way" : way.error().text()));
  if (!way) {
    CHECK(way.error().code == hal::ErrorCode::NotFound);
    CHECK_FALSE(way.error().detail.empty());
  }
}
