#include "planner/motion/collision/near_points.hpp"

#include <algorithm>
#include <cmath>

#include "planner/motion/collision/squared_distances.hpp"

namespace colift::planner {

using Eigen::Vector3i;

namespace {

std::size_t cells_in(const Vector3i& size) {
  return static_cast<std::size_t>(size.x()) * static_cast<std::size_t>(size.y()) *
         static_cast<std::size_t>(size.z());
}

std::size_t index(const Vector3i& size, const Vector3i& at) {
  return static_cast<std::size_t>((static_cast<std::ptrdiff_t>(at.z()) * size.y() + at.y()) * size.x() +
                                  at.x());
}

}  // namespace

NearPoints::NearPoints(const perception::CellGrid& grid, std::span<const Eigen::Vector3f> points,
                       double max_radius_m)
    : count_(grid.nx, grid.ny, grid.nz), cell_m_(grid.cell_m) {
  // one more than cells fit into the radius: what is cut at the reach is farther than it
  const int reach = std::clamp(static_cast<int>(max_radius_m / cell_m_) + 1, 1, kMaxReach_cells);
  const Vector3i beyond = Vector3i::Constant(reach);
  Vector3i &low = points_low_, &high = points_high_;
  low = count_ + beyond, high = -beyond;
  std::vector<Vector3i> cells;
  for (const Eigen::Vector3f& p : points) {
    const hal::Vec3 at = (p.cast<double>() - grid.origin) / cell_m_;
    if (!((at.array() >= -beyond.cast<double>().array()).all() &&
          (at.array() < (count_ + beyond).cast<double>().array()).all()))
      continue;
    const Vector3i cell = at.array().floor().matrix().cast<int>();
    // neighbouring pixels mostly lie in the same cell
    if (!cells.empty() && cells.back() == cell) continue;
    cells.push_back(cell);
    low = low.cwiseMin(cell);
    high = high.cwiseMax(cell);
  }
  if (cells.empty()) return;
  // the points' own cells, and those of the grid that they can reach
  const Vector3i first = low.cwiseMin((low - beyond).cwiseMax(0));
  const Vector3i size =
      high.cwiseMax((high + beyond).cwiseMin(count_ - Vector3i::Ones())) - first + Vector3i::Ones();
  std::vector<std::uint8_t> has_point(cells_in(size), 0);
  for (const Vector3i& cell : cells) has_point[index(size, cell - first)] = 1;
  to_points_ = {first, size, squared_distances({size.x(), size.y(), size.z()}, has_point, reach)};
}

std::int16_t NearPoints::squared(const Vector3i& cell) const {
  // the nearest points of two cells are corners of both
  const Vector3i at = cell - to_points_.first, &size = to_points_.size;
  const std::ptrdiff_t row = size.x() + 1, layer = row * (size.y() + 1);
  const std::int16_t* const c = to_points_.squared.data() + at.z() * layer + at.y() * row + at.x();
  return std::min(
      {c[0], c[1], c[row], c[row + 1], c[layer], c[layer + 1], c[layer + row], c[layer + row + 1]});
}

bool NearPoints::reach(const Vector3i& cell, double radius_m) const {
  const Vector3i at = cell - to_points_.first;
  return !empty() && (at.array() >= 0).all() && (at.array() < to_points_.size.array()).all() &&
         static_cast<double>(squared(cell)) <= limit(radius_m);
}

BoxDistances NearPoints::distances_to(double radius_m, int reach) const {
  if (empty()) return {};
  const Vector3i around = Vector3i::Constant(static_cast<int>(radius_m / cell_m_) + 1);
  const Vector3i low = (points_low_ - around).cwiseMax(to_points_.first).cwiseMax(0);
  const Vector3i high = (points_high_ + around + Vector3i::Ones())
                            .cwiseMin(to_points_.first + to_points_.size)
                            .cwiseMin(count_);
  const Vector3i first = (low - Vector3i::Constant(reach)).cwiseMax(0);
  const Vector3i size = (high + Vector3i::Constant(reach)).cwiseMin(count_) - first;
  if ((size.array() <= 0).any()) return {};
  const auto within = static_cast<std::int16_t>(std::min(limit(radius_m), 32767.0));
  std::vector<std::uint8_t> marked(cells_in(size), 0);
  for (int z = low.z(); z < high.z(); ++z)
    for (int y = low.y(); y < high.y(); ++y)
      for (int x = low.x(); x < high.x(); ++x)
        marked[index(size, Vector3i(x, y, z) - first)] = squared({x, y, z}) <= within;
  if (std::none_of(marked.begin(), marked.end(), [](std::uint8_t m) { return m != 0; })) return {};
  return {first, size, squared_distances({size.x(), size.y(), size.z()}, marked, reach)};
}

}  // namespace colift::planner
