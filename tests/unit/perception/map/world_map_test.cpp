#include "perception/map/world_map.hpp"

#include <octomap/octomap.h>

#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <sstream>

#include "sim_hal/synthetic/scenes.hpp"

namespace {

using namespace colift;
using hal::Vec3;
using perception::CellGrid;
using perception::CellState;
using perception::WorldMap;
using perception::WorldMapConfig;
using sim_hal::Label;

struct Seen {
  sim_hal::SyntheticScene scene;
  sim_hal::Rendering image;
  perception::OrganisedCloud cloud;
  std::vector<std::uint32_t> target;
  std::vector<Vec3> target_points;
  WorldMapConfig config;
};

Seen look(sim_hal::ObjectKind kind, std::uint64_t seed) {
  Seen seen;
  seen.scene = sim_hal::make_scene(kind, seed);
  seen.image = sim_hal::cast_rays(seen.scene.world, seen.scene.intrinsics, seen.scene.X_WC);
  hal::DepthFrame frame;
  frame.intrinsics = seen.scene.intrinsics;
  frame.depth_m = seen.image.depth_m;
  seen.cloud = perception::deproject(frame, seen.scene.X_WC);
  for (std::size_t i = 0; i < seen.cloud.size(); ++i) {
    if (seen.image.label[i] != Label::Target) continue;
    seen.target.push_back(static_cast<std::uint32_t>(i));
    seen.target_points.push_back(seen.cloud.point(i));
  }
  const Vec3 middle = seen.scene.cog;
  seen.config.min_m = {middle.x() - 1.0, middle.y() - 1.0, -0.05};
  seen.config.max_m = {middle.x() + 1.0, middle.y() + 1.0, 1.4};
  return seen;
}

double distance_to_any(const sim_hal::World& world, const Vec3& p) {
  double least = 1e9;
  for (const auto& shape : world.shapes) least = std::min(least, sim_hal::distance(shape, p));
  return least;
}

template <class Work>
void for_cells(const CellGrid& grid, CellState state, Work work) {
  for (int z = 0; z < grid.nz; ++z)
    for (int y = 0; y < grid.ny; ++y)
      for (int x = 0; x < grid.nx; ++x)
        if (grid.cells[grid.index(x, y, z)] == state) work(grid.middle(x, y, z));
}

}  // namespace

TEST_CASE("occupied cells lie on true surfaces, freed ones hold nothing, hidden ones lie behind something") {
  for (const auto kind : {sim_hal::ObjectKind::Table, sim_hal::ObjectKind::Box, sim_hal::ObjectKind::Chair}) {
    for (std::uint64_t seed = 1; seed <= 2; ++seed) {
      const Seen seen = look(kind, seed);
      WorldMap map(seen.config);
      map.insert(seen.cloud, seen.target);
      const double half_diagonal = 0.5 * std::sqrt(3.0) * seen.config.cell_m;
      int occupied = 0, freed = 0, hidden = 0;
      for_cells(map.grid(), CellState::Occupied, [&](const Vec3& middle) {
        ++occupied;
        REQUIRE(std::abs(distance_to_any(seen.scene.world, middle)) <= half_diagonal + 1e-4);
      });
      for_cells(map.grid(), CellState::Free, [&](const Vec3& middle) {
        ++freed;
        REQUIRE(distance_to_any(seen.scene.world, middle) > 0.0);
      });
      for_cells(map.grid(), CellState::Hidden, [&](const Vec3& middle) {
        ++hidden;
        const auto at = seen.cloud.project(middle);
        REQUIRE(seen.cloud.contains(at.u, at.v));
        // in this direction, or within the cell's own size beside it, something stands before its end
        const double reach = 1.0 + 0.5 * seen.scene.intrinsics.fx * seen.config.cell_m / at.depth_m;
        bool before = false;
        for (int dv = -1; dv <= 1; ++dv)
          for (int du = -1; du <= 1; ++du) {
            const double u = std::clamp(at.u + du * reach, 0.0, seen.cloud.width() - 1.0);
            const double v = std::clamp(at.v + dv * reach, 0.0, seen.cloud.height() - 1.0);
            const std::size_t i =
                static_cast<std::size_t>(std::lround(v)) * static_cast<std::size_t>(seen.cloud.width()) +
                static_cast<std::size_t>(std::lround(u));
            before |= seen.cloud.depth_m[i] < at.depth_m + 2.0 * seen.config.cell_m;
          }
        REQUIRE(before);
      });
      CHECK(occupied > 1000);
      CHECK(freed > 50000);
      CHECK(hidden > 1000);
    }
  }
}

TEST_CASE("what a scene's points hit is occupied, but for the target") {
  const Seen seen = look(sim_hal::ObjectKind::Table, 3);
  WorldMap map(seen.config);
  map.insert(seen.cloud, seen.target);
  const CellGrid& grid = map.grid();
  int others = 0, missed = 0, target = 0, target_occupied = 0;
  for (std::size_t i = 0; i < seen.cloud.size(); i += 7) {
    if (!seen.cloud.seen(i)) continue;
    const Eigen::Vector3i c = grid.cell_of(seen.cloud.point(i));
    if (!grid.contains(c.x(), c.y(), c.z())) continue;
    const bool occupied = grid.cells[grid.index(c.x(), c.y(), c.z())] == CellState::Occupied;
    if (seen.image.label[i] == Label::Target) {
      ++target;
      target_occupied += occupied;
    } else {
      ++others;
      missed += !occupied;
    }
  }
  CHECK(missed < others / 100);          // cells that only one ray ends in
  CHECK(target_occupied < target / 20);  // feet share cells with the floor
  map.set_target(seen.target_points);
  for (const Vec3& p : map.target_cells()) {
    const Eigen::Vector3i c = grid.cell_of(p);
    if (!grid.contains(c.x(), c.y(), c.z())) continue;
    REQUIRE(grid.cells[grid.index(c.x(), c.y(), c.z())] != CellState::Occupied);
  }
  CHECK(map.target_cells().size() > 200);
}

TEST_CASE("a thing that is taken away is freed again, and a new one enters") {
  Seen seen = look(sim_hal::ObjectKind::Box, 5);
  WorldMap map(seen.config);
  const Vec3 at = seen.scene.cog + Vec3(0, 0, 0.45);
  sim_hal::World with = seen.scene.world;
  with.shapes.push_back(sim_hal::sphere(at, 0.08, Label::Clutter));
  const auto insert = [&](const sim_hal::World& world) {
    hal::DepthFrame frame;
    frame.intrinsics = seen.scene.intrinsics;
    frame.depth_m = sim_hal::cast_rays(world, seen.scene.intrinsics, seen.scene.X_WC).depth_m;
    map.insert(perception::deproject(frame, seen.scene.X_WC), {});
  };
  const auto near = [&] {
    int count = 0;
    for_cells(map.grid(), CellState::Occupied, [&](const Vec3& m) { count += (m - at).norm() < 0.1; });
    return count;
  };
  insert(with);
  const int there = near();
  CHECK(there > 20);
  for (int i = 0; i < 4; ++i) insert(seen.scene.world);
  CHECK(near() == 0);
  for (int i = 0; i < 6; ++i) insert(with);
  CHECK(near() >= there);
}

TEST_CASE("what was carried off is free with one frame, and so is what it hid; what stands stays (row 51)") {
  Seen seen = look(sim_hal::ObjectKind::Box, 5);
  const Vec3 at = seen.scene.cog + Vec3(0, 0, 0.45);
  sim_hal::World with = seen.scene.world;
  with.shapes.push_back(sim_hal::box(at, {0.16, 0.16, 0.16}, 0.3, Label::Clutter));
  const auto cloud_of = [&](const sim_hal::World& world) {
    hal::DepthFrame frame;
    frame.intrinsics = seen.scene.intrinsics;
    frame.depth_m = sim_hal::cast_rays(world, seen.scene.intrinsics, seen.scene.X_WC).depth_m;
    return perception::deproject(frame, seen.scene.X_WC);
  };
  WorldMap map(seen.config), without(seen.config);
  for (int i = 0; i < 6; ++i) {
    map.insert(cloud_of(with), {});
    without.insert(cloud_of(seen.scene.world), {});
  }
  const auto count = [&](CellState state) {
    int n = 0;
    for_cells(map.grid(), state, [&](const Vec3& m) { n += (m - at).norm() < 0.2; });
    return n;
  };
  const int occupied = count(CellState::Occupied), hidden = count(CellState::Hidden);
  REQUIRE(occupied > 50);
  REQUIRE(hidden > 50);

  SECTION("as it was: nothing changes") {
    CHECK(map.free_carried_off(cloud_of(with)) == 0);
    CHECK(count(CellState::Occupied) == occupied);
    CHECK(count(CellState::Hidden) == hidden);
  }
  SECTION("carried off") {
    CHECK(map.free_carried_off(cloud_of(seen.scene.world)) > 50);
    CHECK(count(CellState::Occupied) == 0);
    CHECK(count(CellState::Hidden) < hidden / 20);
    // and of all else the map says what it would have said without it
    int lost = 0, all = 0;
    for_cells(without.grid(), CellState::Occupied, [&](const Vec3& m) {
      const Eigen::Vector3i c = map.grid().cell_of(m);
      ++all;
      lost += map.grid().cells[map.grid().index(c.x(), c.y(), c.z())] == CellState::Free;
    });
    CHECK(all > 1000);
    CHECK(lost == 0);
  }
  SECTION("somebody stands before it, or nothing is measured there: nobody knows") {
    auto blind = cloud_of(seen.scene.world);
    const bool measured = GENERATE(true, false);
    for (float& d : blind.depth_m) d = measured ? 0.5f : std::numeric_limits<float>::quiet_NaN();
    CHECK(map.free_carried_off(blind) == 0);
    CHECK(count(CellState::Occupied) == occupied);
  }
  SECTION("a few flying pixels free nothing") {
    auto noisy = cloud_of(with);
    for (std::size_t i = 0; i < noisy.size(); i += 37) noisy.depth_m[i] = 6.0f;
    CHECK(map.free_carried_off(noisy) == 0);
  }
}

TEST_CASE("the robot's own cells are carved out with their padding, others stay") {
  const Seen seen = look(sim_hal::ObjectKind::Box, 2);
  WorldMapConfig config;
  WorldMap map(config);
  const hal::RobotModel& robot = hal::built_in_robot();
  hal::JointVector q = hal::JointVector::Zero();
  q[1] = 0.6;
  map.carve_robot(robot, q, {});
  std::vector<hal::Pose> X_WL;
  hal::link_poses(robot, q, {}, X_WL);
  int carved = 0;
  for_cells(map.grid(), CellState::Free, [&](const Vec3& middle) {
    ++carved;
    double least = 1e9;
    for (std::size_t l = 0; l < robot.links.size(); ++l)
      for (const auto& shape : robot.links[l].shapes) {
        sim_hal::Shape same;
        same.kind = shape.kind == hal::LinkShape::Kind::Box        ? sim_hal::Shape::Kind::Box
                    : shape.kind == hal::LinkShape::Kind::Cylinder ? sim_hal::Shape::Kind::Cylinder
                                                                   : sim_hal::Shape::Kind::Sphere;
        same.X_WS = X_WL[l] * shape.X_LS;
        same.size = shape.size;
        least = std::min(least, sim_hal::distance(same, middle));
      }
    REQUIRE(least <= config.robot_padding_m + 1e-6);
  });
  CHECK(carved > 3000);
  const Eigen::Vector3i palm = map.grid().cell_of(X_WL[static_cast<std::size_t>(robot.palm)].translation());
  CHECK(map.grid().cells[map.grid().index(palm.x(), palm.y(), palm.z())] == CellState::Free);
  (void)seen;
}

TEST_CASE("the octree says of every cell what the grid says") {
  const Seen seen = look(sim_hal::ObjectKind::Chair, 4);
  WorldMap map(seen.config);
  map.insert(seen.cloud, seen.target);
  const CellGrid& grid = map.grid();
  const octomap::OcTree& tree = map.tree();
  std::size_t occupied = 0;
  for (int z = 0; z < grid.nz; ++z)
    for (int y = 0; y < grid.ny; ++y)
      for (int x = 0; x < grid.nx; ++x) {
        const Vec3 p = grid.middle(x, y, z);
        const auto* node = tree.search(p.x(), p.y(), p.z());
        const CellState state = grid.cells[grid.index(x, y, z)];
        const bool known = state == CellState::Free || state == CellState::Occupied;
        REQUIRE((node != nullptr) == known);
        if (known) REQUIRE(tree.isNodeOccupied(node) == (state == CellState::Occupied));
        occupied += state == CellState::Occupied;
      }
  CHECK(occupied == map.occupied_cells());
  CHECK(tree.size() == tree.calcNumNodes());
}

TEST_CASE("a map comes back from its tree as it was, and from OctoMap's file of it") {
  const Seen seen = look(sim_hal::ObjectKind::Table, 6);
  WorldMap map(seen.config);
  map.insert(seen.cloud, seen.target);
  std::stringstream file;
  REQUIRE(map.tree().writeBinaryConst(file));
  octomap::OcTree read(0.1);
  REQUIRE(read.readBinary(file));
  for (const octomap::OcTree* tree : {&map.tree(), static_cast<const octomap::OcTree*>(&read)}) {
    const auto back = WorldMap::from_tree(*tree, seen.config);
    REQUIRE(back);
    CHECK(back->occupied_cells() == map.occupied_cells());
    const CellGrid &a = map.grid(), &b = back->grid();
    REQUIRE(a.cells.size() == b.cells.size());
    for (std::size_t i = 0; i < a.cells.size(); ++i) {
      const bool known = a.cells[i] == CellState::Free || a.cells[i] == CellState::Occupied;
      REQUIRE(b.cells[i] == (known ? a.cells[i] : CellState::OutOfView));
    }
  }
}

TEST_CASE("an empty tree makes an empty map, one with other cells is refused") {
  const WorldMapConfig config;
  const auto empty = WorldMap::from_tree(octomap::OcTree(config.cell_m), config);
  REQUIRE(empty);
  CHECK(empty->occupied_cells() == 0);
  const auto coarse = WorldMap::from_tree(octomap::OcTree(0.05), config);
  REQUIRE_FALSE(coarse);
  CHECK(coarse.error().code == hal::ErrorCode::BadInput);
}
