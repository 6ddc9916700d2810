#include "planner/motion/collision/near_points.hpp"

#include <catch2/catch.hpp>

#include "planner/motion/collision/distance_field.hpp"
#include "sim_hal/synthetic/hash_random.hpp"

namespace {

using namespace colift;
using Eigen::Vector3f;
using Eigen::Vector3i;

perception::CellGrid small_grid() {
  perception::CellGrid grid;
  grid.cell_m = 0.02;
  grid.origin = {-0.2, -0.3, 0.0};
  grid.nx = 25, grid.ny = 30, grid.nz = 20;
  return grid;
}

std::vector<Vector3f> points_around(const perception::CellGrid& grid, std::uint64_t seed, int count) {
  sim_hal::Draws draws(seed, 1);
  const hal::Vec3 size = grid.cell_m * hal::Vec3(grid.nx, grid.ny, grid.nz);
  std::vector<Vector3f> points;
  for (int i = 0; i < count; ++i) {
    hal::Vec3 p = grid.origin;
    for (int axis = 0; axis < 3; ++axis) p[axis] += draws.between(-0.3, size[axis] + 0.3);
    points.push_back(p.cast<float>());
  }
  return points;
}

/// Whether the nearest points of a cell and of the cell of one of the points are within the radius.
bool near_by_definition(const perception::CellGrid& grid, const std::vector<Vector3f>& points,
                        const Vector3i& cell, double radius_m) {
  for (const Vector3f& p : points) {
    const Vector3i gap = ((grid.cell_of(p.cast<double>()) - cell).cwiseAbs() - Vector3i::Ones()).cwiseMax(0);
    if (grid.cell_m * gap.cast<double>().norm() <= radius_m) return true;
  }
  return false;
}

}  // namespace

TEST_CASE("cells near to points, inside and outside of the grid, are those of the definition") {
  const perception::CellGrid grid = small_grid();
  constexpr double kMax = 0.11;
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    const auto points = points_around(grid, seed, 12);
    const planner::NearPoints near(grid, points, kMax);
    for (const double radius : {0.0, 0.05, kMax}) {
      int wrong = 0;
      for (int z = 0; z < grid.nz; ++z)
        for (int y = 0; y < grid.ny; ++y)
          for (int x = 0; x < grid.nx; ++x)
            wrong += near_by_definition(grid, points, {x, y, z}, radius) != near.reach({x, y, z}, radius);
      CAPTURE(seed, radius);
      CHECK(wrong == 0);
    }
  }
}

TEST_CASE("without points, or with all of them far away, nothing is near") {
  const perception::CellGrid grid = small_grid();
  const std::vector<Vector3f> far{{5.0f, 5.0f, 5.0f}, {-9.0f, 0.0f, 0.1f}, {NAN, 0.0f, 0.0f}};
  for (const auto& points : {std::vector<Vector3f>{}, far}) {
    const planner::NearPoints near(grid, points, 0.3);
    CHECK(near.empty());
    CHECK_FALSE(near.reach({3, 3, 3}, 0.3));
    CHECK(near.distances_to(0.3, 2).squared.empty());
  }
}

TEST_CASE("a field to which obstacles are added is the field of all of them") {
  const perception::CellGrid grid = small_grid();
  const std::size_t count = 25 * 30 * 20;
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    sim_hal::Draws draws(seed, 2);
    std::vector<std::uint8_t> first(count, 0);
    for (auto& cell : first) cell = draws.chance(seed == 4 ? 0.0 : 0.001);
    const planner::NearPoints near(grid, points_around(grid, seed, 3), 0.1);
    std::vector<std::uint8_t> all = first;
    for (int z = 0; z < grid.nz; ++z)
      for (int y = 0; y < grid.ny; ++y)
        for (int x = 0; x < grid.nx; ++x)
          if (near.reach({x, y, z}, 0.06)) all[grid.index(x, y, z)] = 1;
    planner::DistanceField field(grid, first, 0.2);
    field.add(near.distances_to(0.06, field.reach_cells()));
    const planner::DistanceField whole(grid, all, 0.2);
    for (int i = 0; i < 2000; ++i) {
      const Vector3f p(static_cast<float>(draws.between(-0.3, 0.4)),
                       static_cast<float>(draws.between(-0.4, 0.4)),
                       static_cast<float>(draws.between(-0.1, 0.5)));
      REQUIRE(field.distance(p) == whole.distance(p));
    }
  }
}
