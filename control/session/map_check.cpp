#include "control/session/map_check.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <vector>

namespace colift::control {
namespace {

using perception::CellGrid;
using perception::CellState;

constexpr int kStride = 5;  // every 25th pixel: 12 000 of a Kinect's, in well under a millisecond

/// Whether one of the 27 cells about a point holds something.
bool holds(const CellGrid& grid, const std::vector<char>& is_something, const Eigen::Vector3i& c) {
  for (int around = 0; around < 27; ++around) {
    const int x = c.x() + around % 3 - 1, y = c.y() + around / 3 % 3 - 1, z = c.z() + around / 9 - 1;
    if (grid.contains(x, y, z) && is_something[grid.index(x, y, z)] != 0) return true;
  }
  return false;
}

}  // namespace

std::optional<std::string> map_fault(const perception::WorldMap& map, const perception::OrganisedCloud& cloud,
                                     const MapCheckConfig& config) {
  const CellGrid& grid = map.grid();
  std::vector<char> is_something(grid.cells.size());
  std::size_t known = 0, occupied = 0;
  for (std::size_t i = 0; i < grid.cells.size(); ++i) {
    const bool something = grid.cells[i] == CellState::Occupied;
    is_something[i] = something ? 1 : 0;
    occupied += something;
    known += something || grid.cells[i] == CellState::Free;
  }
  if (known > 0 && static_cast<double>(occupied) > config.max_occupied_fraction * static_cast<double>(known))
    return fmt::format("the map of the room is full: {:.0f} % of what is known of it is occupied",
                       1e2 * static_cast<double>(occupied) / static_cast<double>(known));
  for (const hal::Vec3& middle : map.target_cells()) {
    const Eigen::Vector3i c = grid.cell_of(middle);
    if (grid.contains(c.x(), c.y(), c.z())) is_something[grid.index(c.x(), c.y(), c.z())] = 1;
  }
  int points = 0, kept = 0;
  for (int v = 0; v < cloud.height(); v += kStride)
    for (int u = 0; u < cloud.width(); u += kStride) {
      const auto pixel =
          static_cast<std::size_t>(v) * static_cast<std::size_t>(cloud.width()) + static_cast<std::size_t>(u);
      if (!cloud.seen(pixel) || cloud.depth_m[pixel] > static_cast<float>(config.max_distance_m)) continue;
      const Eigen::Vector3i c = grid.cell_of(cloud.point(pixel));
      if (!grid.contains(c.x(), c.y(), c.z())) continue;
      ++points;
      kept += holds(grid, is_something, c);
    }
  if (points >= config.min_points && kept < config.min_kept_fraction * points)
    return fmt::format("the map of the room is too empty: it holds {:.0f} % of what the camera sees there",
                       1e2 * kept / points);
  return std::nullopt;
}

}  // namespace colift::control
