#include "planner/motion/collision/distance_field.hpp"

#include <catch2/catch.hpp>
#include <cmath>

#include "sim_hal/synthetic/hash_random.hpp"

namespace {

using namespace colift;
using Eigen::Vector3f;

struct Cells {
  perception::CellGrid grid;
  std::vector<std::uint8_t> is_obstacle;
};

Cells random_cells(std::uint64_t seed, double density) {
  sim_hal::Draws draws(seed, 1);
  Cells cells;
  cells.grid.cell_m = draws.between(0.01, 0.03);
  cells.grid.origin = {draws.between(-1, 1), draws.between(-1, 1), draws.between(-1, 1)};
  cells.grid.nx = 8 + draws.below(12);
  cells.grid.ny = 8 + draws.below(12);
  cells.grid.nz = 8 + draws.below(12);
  const int count = cells.grid.nx * cells.grid.ny * cells.grid.nz;
  for (int i = 0; i < count; ++i) cells.is_obstacle.push_back(draws.chance(density));
  return cells;
}

double true_distance(const Cells& cells, const hal::Vec3& p) {
  double least = 1e9;
  const auto& g = cells.grid;
  for (int z = 0; z < g.nz; ++z)
    for (int y = 0; y < g.ny; ++y)
      for (int x = 0; x < g.nx; ++x) {
        if (cells.is_obstacle[g.index(x, y, z)] == 0) continue;
        const hal::Vec3 away = (p - g.middle(x, y, z)).cwiseAbs() - hal::Vec3::Constant(0.5 * g.cell_m);
        least = std::min(least, away.cwiseMax(0.0).norm());
      }
  return least;
}

}  // namespace

TEST_CASE("a distance is never more than the true one to any point of an obstacle cell, nor far below it") {
  double worst_loss_cells = 0.0;
  for (std::uint64_t seed = 1; seed <= 12; ++seed) {
    const Cells cells = random_cells(seed, seed % 3 == 0 ? 0.02 : 0.002);
    const double max_m = 0.25;
    const planner::DistanceField field(cells.grid, cells.is_obstacle, max_m);
    if (field.empty()) continue;
    sim_hal::Draws draws(seed, 2);
    const auto& g = cells.grid;
    const hal::Vec3 size = g.cell_m * hal::Vec3(g.nx, g.ny, g.nz);
    for (int i = 0; i < 400; ++i) {
      hal::Vec3 p = g.origin;
      for (int axis = 0; axis < 3; ++axis) p[axis] += draws.between(-0.1, size[axis] + 0.1);
      const double truth = true_distance(cells, p);
      const double said = field.distance(p.cast<float>());
      REQUIRE(said <= truth + 1e-6);
      REQUIRE(said <= field.max_m());
      const hal::Vec3 in = p - g.origin;
      if ((in.array() < 0.0).any() || (in.array() > size.array()).any()) continue;
      worst_loss_cells =
          std::max(worst_loss_cells, (std::min<double>(truth, field.max_m()) - said) / g.cell_m);
    }
  }
  CHECK(worst_loss_cells < 0.9);  // half a cell's diagonal, in a cell with obstacles at all corners
}

TEST_CASE("a distance at a cell's corner is exact") {
  const Cells cells = random_cells(4, 0.004);
  const planner::DistanceField field(cells.grid, cells.is_obstacle, 0.5);
  REQUIRE_FALSE(field.empty());
  sim_hal::Draws draws(4, 2);
  for (int i = 0; i < 300; ++i) {
    const auto& g = cells.grid;
    const hal::Vec3 p =
        g.origin + g.cell_m * hal::Vec3(draws.below(g.nx), draws.below(g.ny), draws.below(g.nz));
    CHECK(field.distance(p.cast<float>()) ==
          Approx(std::min<double>(true_distance(cells, p), field.max_m())).margin(0.035 * g.cell_m));
  }
}

TEST_CASE("clear() agrees with distance(), and a look-up that is enough is clear in truth") {
  const Cells cells = random_cells(7, 0.003);
  const planner::DistanceField field(cells.grid, cells.is_obstacle, 0.3);
  REQUIRE_FALSE(field.empty());
  sim_hal::Draws draws(7, 3);
  int enough = 0, not_enough = 0;
  for (int i = 0; i < 3000; ++i) {
    const auto& g = cells.grid;
    Vector3f p = g.origin.cast<float>();
    for (int axis = 0; axis < 3; ++axis) p[axis] += static_cast<float>(draws.between(-0.1, 0.6));
    const auto radius = static_cast<float>(draws.between(0.0, 0.15));
    if (std::abs(field.distance(p) - radius) > 1e-6f) {
      REQUIRE(field.clear(p, radius) == (field.distance(p) >= radius));
    }
    std::int16_t squared = 0;
    field.look_up(&p.x(), &p.y(), &p.z(), 1, &squared);
    const bool is_enough = squared >= field.enough(radius);
    (is_enough ? enough : not_enough)++;
    if (is_enough) REQUIRE(true_distance(cells, p.cast<double>()) >= radius);
  }
  CHECK(enough > 100);
  CHECK(not_enough > 100);
}

TEST_CASE("a field without obstacles is clear everywhere") {
  Cells cells = random_cells(5, 0.0);
  const planner::DistanceField field(cells.grid, cells.is_obstacle, 0.3);
  CHECK(field.empty());
  CHECK(field.clear({0, 0, 0}, 5.0f));
  CHECK(planner::DistanceField().clear({0, 0, 0}, 5.0f));
}
