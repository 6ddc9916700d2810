#include "planner/motion/collision/collision_scene.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>

#include "hal/types/avx2.hpp"
#include "planner/motion/collision/near_points.hpp"

namespace colift::planner {
namespace {

using perception::CellGrid;
using perception::CellState;

/// How far the fields reach beyond the margin: the largest group of spheres that is asked for at once (m).
constexpr double kReach = 0.28;

using Cell = std::array<int, 3>;

Cell cell_of(const CellGrid& grid, const hal::Vec3& p_W) {
  const hal::Vec3 at = (p_W - grid.origin) / grid.cell_m;
  return {static_cast<int>(std::floor(at.x())), static_cast<int>(std::floor(at.y())),
          static_cast<int>(std::floor(at.z()))};
}

std::size_t index_of(const CellGrid& grid, int x, int y, int z) {
  return static_cast<std::size_t>((static_cast<std::ptrdiff_t>(z) * grid.ny + y) * grid.nx + x);
}

/// For each column of cells whether it is farther from the robot's axis than `radius_m`.
std::vector<std::uint8_t> beyond_own_space(const CellGrid& grid, double radius_m) {
  const hal::Vec3 first = grid.origin + hal::Vec3::Constant(0.5 * grid.cell_m);
  std::vector<std::uint8_t> beyond;
  beyond.reserve(static_cast<std::size_t>(grid.nx) * static_cast<std::size_t>(grid.ny));
  for (int iy = 0; iy < grid.ny; ++iy)
    for (int ix = 0; ix < grid.nx; ++ix)
      beyond.push_back(std::hypot(first.x() + grid.cell_m * ix, first.y() + grid.cell_m * iy) > radius_m);
  return beyond;
}

/// `n` cells of a row: `measured` becomes 1 where they are occupied, `kept_out` there too, and where they are
/// unseen and that counts.
COLIFT_ALSO_AVX2 void keep_out(const CellState* __restrict state,
                               const std::uint8_t* __restrict unseen_counts, int n, const SceneConfig& config,
                               std::uint8_t* __restrict measured, std::uint8_t* __restrict kept_out) {
  const std::uint8_t hidden_counts = config.hidden_is_obstacle,
                     out_of_view_counts = config.out_of_view_is_obstacle;
  for (int i = 0; i < n; ++i) {
    const auto is = [&](CellState s) { return static_cast<std::uint8_t>(state[i] == s); };
    const auto occupied = is(CellState::Occupied);
    const auto unseen =
        (is(CellState::Hidden) & hidden_counts) | (is(CellState::OutOfView) & out_of_view_counts);
    measured[i] = occupied;
    kept_out[i] = static_cast<std::uint8_t>(occupied | (unseen & unseen_counts[i]));
  }
}

/// Frees what a depth image strews around the edges of the target: lone groups of a few cells right beside
/// it. Larger groups, and small ones elsewhere, are things.
void drop_specks(const CellGrid& grid, std::span<const hal::Vec3> target_cells, const SceneConfig& config,
                 std::vector<std::uint8_t>& occupied) {
  const auto few = static_cast<std::size_t>(config.min_obstacle_cells);
  std::vector<std::uint8_t> done(occupied.size(), 0);
  std::vector<Cell> group;
  // the occupied ones; rows mostly have none
  const auto each_around = [&](const Cell& c, int reach, auto&& visit) {
    const int x_end = std::min(c[0] + reach + 1, grid.nx), y_end = std::min(c[1] + reach + 1, grid.ny),
              z_end = std::min(c[2] + reach + 1, grid.nz), x_begin = std::max(c[0] - reach, 0);
    for (int z = std::max(c[2] - reach, 0); z < z_end; ++z)
      for (int y = std::max(c[1] - reach, 0); y < y_end; ++y) {
        const std::uint8_t* const row = occupied.data() + index_of(grid, 0, y, z);
        for (int x = x_begin; x < x_end; ++x) {
          const void* const found = std::memchr(row + x, 1, static_cast<std::size_t>(x_end - x));
          if (found == nullptr) break;
          x = static_cast<int>(static_cast<const std::uint8_t*>(found) - row);
          visit(Cell{x, y, z}, index_of(grid, x, y, z));
        }
      }
  };
  for (const hal::Vec3& middle : target_cells) {
    each_around(cell_of(grid, middle), config.speck_distance_cells, [&](const Cell& seed, std::size_t at) {
      if (done[at]) return;
      group.assign(1, seed);
      done[at] = 1;
      for (std::size_t k = 0; k < group.size(); ++k) {
        const Cell from = group[k];
        each_around(from, 1, [&](const Cell& n, std::size_t i) {
          if (done[i]) return;
          done[i] = 1;
          group.push_back(n);
        });
      }
      if (group.size() >= few) return;
      for (const Cell& c : group) occupied[index_of(grid, c[0], c[1], c[2])] = 0;
    });
  }
}

}  // namespace

CollisionScene make_collision_scene(const perception::WorldMap& map, const hal::Plane& ground,
                                    const SceneConfig& config) {
  const CellGrid& grid = map.grid();
  std::vector<std::uint8_t> measured(grid.cells.size(), 0), kept_out(grid.cells.size(), 0);
  const hal::Vec3 first = grid.origin + hal::Vec3::Constant(0.5 * grid.cell_m);
  const std::vector<std::uint8_t> unseen_counts = beyond_own_space(grid, config.own_space_m);
  const double lowest = kGroundCells * grid.cell_m;
  for (int iz = 0; iz < grid.nz; ++iz) {
    for (int iy = 0; iy < grid.ny; ++iy) {
      const double row = ground.height(first + grid.cell_m * hal::Vec3(0, iy, iz));
      const auto above_ground = [&](int ix) { return row + grid.cell_m * ix * ground.normal.x() >= lowest; };
      // the height changes evenly along a row: mostly all of it or nothing is above
      int from = 0, to = grid.nx;
      if (!above_ground(0) && !above_ground(to - 1)) continue;
      while (from < to && !above_ground(from)) ++from;
      while (from < to && !above_ground(to - 1)) --to;
      const std::ptrdiff_t begin = (static_cast<std::ptrdiff_t>(iz) * grid.ny + iy) * grid.nx;
      keep_out(grid.cells.data() + begin + from,
               unseen_counts.data() + static_cast<std::ptrdiff_t>(iy) * grid.nx + from, to - from, config,
               measured.data() + begin + from, kept_out.data() + begin + from);
    }
  }
  drop_specks(grid, map.target_cells(), config, measured);
  std::vector<std::uint8_t> target(grid.cells.size(), 0);
  CollisionScene scene;
  for (const hal::Vec3& middle : map.target_cells()) {
    const Cell c = cell_of(grid, middle);
    if (c[0] < 0 || c[1] < 0 || c[2] < 0 || c[0] >= grid.nx || c[1] >= grid.ny || c[2] >= grid.nz) continue;
    scene.carried_W.push_back(middle.cast<float>());
    target[index_of(grid, c[0], c[1], c[2])] = 1;
  }
  const double reach = kReach + config.margin_m;
  scene.obstacles = DistanceField(grid, measured, reach);
  scene.arm_obstacles = DistanceField(grid, kept_out, reach);
  scene.target = DistanceField(grid, target, reach);
  scene.ground = ground;
  scene.carried_cell_m = static_cast<float>(grid.cell_m);
  scene.config = config;
  return scene;
}

CollisionScene with_obstacle(const CollisionScene& scene, const CellGrid& grid,
                             std::span<const Eigen::Vector3f> points, double clearance_m) {
  CollisionScene with = scene;
  const double beyond_m = std::max(0.0, clearance_m - scene.config.margin_m);
  const BoxDistances around =
      NearPoints(grid, points, beyond_m).distances_to(beyond_m, with.obstacles.reach_cells());
  with.obstacles.add(around);
  with.arm_obstacles.add(around);
  return with;
}

CollisionScene with_partner(const CollisionScene& scene, const CellGrid& grid,
                            std::span<const Eigen::Vector3f> partner_points) {
  CollisionScene with = scene;
  const SceneConfig& config = scene.config;
  const double partner = config.partner_clearance_m - config.margin_m;
  const double contact = std::max(0.0, partner) + config.partner_contact_m;
  const NearPoints near_partner(grid, partner_points, contact);
  if (partner >= 0.0) {
    const BoxDistances around = near_partner.distances_to(partner, with.obstacles.reach_cells());
    with.obstacles.add(around);
    with.arm_obstacles.add(around);
  }
  // where he holds it, the object touches him, and goes on doing so while both lift
  std::erase_if(with.carried_W, [&](const Eigen::Vector3f& middle) {
    return near_partner.reach(grid.cell_of(middle.cast<double>()), contact);
  });
  return with;
}

CollisionScene make_collision_scene(const perception::WorldMap& map, const hal::Plane& ground,
                                    std::span<const Eigen::Vector3f> partner_points,
                                    const SceneConfig& config) {
  return with_partner(make_collision_scene(map, ground, config), map.grid(), partner_points);
}

}  // namespace colift::planner
