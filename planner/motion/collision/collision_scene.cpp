#include "planner/motion/collision/collision_scene.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <set>

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

/// Marks the cells whose nearest point comes within `radius_m` of a cell with a point in it.
void mark_around(const CellGrid& grid, std::span<const Eigen::Vector3f> points, double radius_m,
                 std::vector<std::uint8_t>& is_obstacle) {
  const int reach = static_cast<int>(std::ceil(radius_m / grid.cell_m));
  std::set<Cell> centers;
  for (const Eigen::Vector3f& p : points) {
    const Cell c = cell_of(grid, p.cast<double>());
    if (c[0] < -reach || c[1] < -reach || c[2] < -reach || c[0] >= grid.nx + reach ||
        c[1] >= grid.ny + reach || c[2] >= grid.nz + reach) {
      continue;
    }
    centers.insert(c);
  }
  const double limit = radius_m / grid.cell_m;
  const auto gap = [](int d) { return static_cast<double>(std::max(0, std::abs(d) - 1)); };
  for (const Cell& c : centers) {
    for (int dz = -reach; dz <= reach; ++dz) {
      for (int dy = -reach; dy <= reach; ++dy) {
        const int y = c[1] + dy, z = c[2] + dz;
        if (y < 0 || z < 0 || y >= grid.ny || z >= grid.nz) continue;
        const double left = limit * limit - gap(dy) * gap(dy) - gap(dz) * gap(dz);
        if (left < 0.0) continue;
        const int wide = std::min(reach, static_cast<int>(std::sqrt(left)) + 1);
        const int from = std::max(0, c[0] - wide), to = std::min(grid.nx - 1, c[0] + wide);
        for (int x = from; x <= to; ++x) is_obstacle[index_of(grid, x, y, z)] = 1;
      }
    }
  }
}

/// Frees what a depth image strews around the edges of the target: lone groups of a few cells right beside
/// it. Larger groups, and small ones elsewhere, are things.
void drop_specks(const CellGrid& grid, std::span<const hal::Vec3> target_cells, const SceneConfig& config,
                 std::vector<std::uint8_t>& occupied) {
  const auto few = static_cast<std::size_t>(config.min_obstacle_cells);
  std::vector<std::uint8_t> done(occupied.size(), 0);
  std::vector<Cell> group;
  const auto inside = [&](const Cell& c) {
    return c[0] >= 0 && c[1] >= 0 && c[2] >= 0 && c[0] < grid.nx && c[1] < grid.ny && c[2] < grid.nz;
  };
  const auto each_around = [&](const Cell& c, int reach, auto&& visit) {
    for (int dz = -reach; dz <= reach; ++dz)
      for (int dy = -reach; dy <= reach; ++dy)
        for (int dx = -reach; dx <= reach; ++dx) {
          const Cell n{c[0] + dx, c[1] + dy, c[2] + dz};
          if (inside(n)) visit(n, index_of(grid, n[0], n[1], n[2]));
        }
  };
  for (const hal::Vec3& middle : target_cells) {
    each_around(cell_of(grid, middle), config.speck_distance_cells, [&](const Cell& seed, std::size_t at) {
      if (!occupied[at] || done[at]) return;
      group.assign(1, seed);
      done[at] = 1;
      for (std::size_t k = 0; k < group.size(); ++k) {
        const Cell from = group[k];
        each_around(from, 1, [&](const Cell& n, std::size_t i) {
          if (!occupied[i] || done[i]) return;
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
                                    std::span<const Eigen::Vector3f> partner_points,
                                    const SceneConfig& config) {
  const CellGrid& grid = map.grid();
  std::vector<std::uint8_t> measured(grid.cells.size(), 0), kept_out(grid.cells.size(), 0);
  const hal::Vec3 first = grid.origin + hal::Vec3::Constant(0.5 * grid.cell_m);
  std::size_t i = 0;
  for (int iz = 0; iz < grid.nz; ++iz) {
    for (int iy = 0; iy < grid.ny; ++iy) {
      const double row = ground.height(first + grid.cell_m * hal::Vec3(0, iy, iz));
      for (int ix = 0; ix < grid.nx; ++ix, ++i) {
        const double height = row + grid.cell_m * ix * ground.normal.x();
        if (height < kGroundCells * grid.cell_m) continue;
        const CellState state = grid.cells[i];
        const bool occupied = state == CellState::Occupied;
        measured[i] = occupied;
        const double x = first.x() + grid.cell_m * ix, y = first.y() + grid.cell_m * iy;
        const bool unseen = (state == CellState::Hidden && config.hidden_is_obstacle) ||
                            (state == CellState::OutOfView && config.out_of_view_is_obstacle);
        kept_out[i] = occupied || (unseen && std::hypot(x, y) > config.own_space_m);
      }
    }
  }
  drop_specks(grid, map.target_cells(), config, measured);
  const double partner = config.partner_clearance_m - config.margin_m;
  if (partner >= 0.0) {
    mark_around(grid, partner_points, partner, measured);
    mark_around(grid, partner_points, partner, kept_out);
  }
  // where he holds it, the object touches him, and goes on doing so while both lift
  std::vector<std::uint8_t> in_his_hands(grid.cells.size(), 0);
  mark_around(grid, partner_points, std::max(0.0, partner) + config.partner_contact_m, in_his_hands);
  std::vector<std::uint8_t> target(grid.cells.size(), 0);
  CollisionScene scene;
  for (const hal::Vec3& middle : map.target_cells()) {
    const Cell c = cell_of(grid, middle);
    const bool inside =
        c[0] >= 0 && c[1] >= 0 && c[2] >= 0 && c[0] < grid.nx && c[1] < grid.ny && c[2] < grid.nz;
    if (inside && in_his_hands[index_of(grid, c[0], c[1], c[2])] == 0)
      scene.carried_W.push_back(middle.cast<float>());
    if (!inside) continue;
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

}  // namespace colift::planner
