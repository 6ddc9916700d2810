#include "perception/map/unseen_space.hpp"

#include <algorithm>
#include <cmath>

namespace colift::perception {
namespace {

constexpr double kSideways_m = 0.3, kAbove_m = 0.1;

}  // namespace

double unseen_fraction(const WorldMap& map, const hal::Aabb& box_W) {
  const CellGrid& grid = map.grid();
  const Eigen::Vector3i n(grid.nx, grid.ny, grid.nz);
  const Eigen::Vector3i from = grid.cell_of(box_W.min()).cwiseMax(0),
                        to = (grid.cell_of(box_W.max()) + Eigen::Vector3i::Ones()).cwiseMin(n);
  std::size_t all = 0, unseen = 0;
  for (int z = from.z(); z < to.z(); ++z)
    for (int y = from.y(); y < to.y(); ++y)
      for (int x = from.x(); x < to.x(); ++x, ++all) {
        const CellState state = grid.cells[grid.index(x, y, z)];
        unseen += state == CellState::Hidden || state == CellState::OutOfView;
      }
  for (const hal::Vec3& middle : map.target_cells()) {
    const Eigen::Vector3i c = grid.cell_of(middle);
    if ((c.array() < from.array()).any() || (c.array() >= to.array()).any()) continue;
    --all;
    const CellState state = grid.cells[grid.index(c.x(), c.y(), c.z())];
    unseen -= state == CellState::Hidden || state == CellState::OutOfView;
  }
  return all > 0 ? static_cast<double>(unseen) / static_cast<double>(all) : NAN;
}

hal::Aabb space_around(const hal::OrientedBox& object, double ground_z_m) {
  hal::Aabb box;
  for (int corner = 0; corner < 8; ++corner) {
    const hal::Vec3 half(corner & 1 ? 0.5 : -0.5, corner & 2 ? 0.5 : -0.5, corner & 4 ? 0.5 : -0.5);
    box.extend(object.center + object.axes * object.size.cwiseProduct(half));
  }
  box.min() -= hal::Vec3(kSideways_m, kSideways_m, 0.0);
  box.max() += hal::Vec3(kSideways_m, kSideways_m, kAbove_m);
  box.min().z() = ground_z_m;
  return box;
}

}  // namespace colift::perception
