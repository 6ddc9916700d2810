#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "hal/types/geometry.hpp"
#include "perception/map/world_map.hpp"

namespace colift::planner {

struct BoxDistances;

/// Distance to the nearest obstacle cell, cut at `max_m`. Exact at the corners of the grid's cells: the
/// squared distance in cells is a whole number there and is stored as such. Between them
///
///     d(p)^2 >= sum_i w_i d(v_i)^2 - cell^2 sum_axes t (1 - t)
///
/// with trilinear weights w_i and places t in [0, 1] within the cell: d(p)^2 - |p|^2 is the smallest of
/// linear functions of p, thus concave, and no mean of its values at the corners lies above it. So distance()
/// never says more than the true distance from p to the nearest point of any obstacle cell, and is exact
/// beside flat obstacles but for a quarter of a cell squared.
class DistanceField {
 public:
  DistanceField() = default;
  /// `is_obstacle` holds 0 or 1 for every cell of the grid, in its order. `max_m` is rounded up to whole
  /// cells; at most kMaxReach_cells of them.
  DistanceField(const perception::CellGrid& grid, const std::vector<std::uint8_t>& is_obstacle,
                double max_m = 0.4);

  /// Adds obstacles, to this copy alone: afterwards it is the field of all of them. Both fields have the same
  /// grid and reach.
  void add(const BoxDistances& obstacles);

  /// Lower bound of the distance (m), at most max_m(); 0 inside obstacles. Outside of the grid too.
  [[nodiscard]] float distance(const Eigen::Vector3f& p_W) const;
  /// distance(p_W) >= radius_m, without the root. `radius_m` must not be over max_m().
  [[nodiscard]] bool clear(const Eigen::Vector3f& p_W, float radius_m) const;

  /// Squared distance, in cells, at the cell corner that is nearest to each of `count` points: a fast first
  /// question, see enough().
  void look_up(const float* x, const float* y, const float* z, int count, std::int16_t* squared) const;
  /// From this value of look_up() on, a point is at least radius_m from every obstacle.
  [[nodiscard]] std::int16_t enough(float radius_m) const;

  [[nodiscard]] float max_m() const { return max_m_; }
  [[nodiscard]] float cell_m() const { return cell_m_; }
  /// Made without any obstacle (or not made at all): everything is clear.
  [[nodiscard]] bool empty() const { return squared_ == nullptr; }
  /// How far it looks, in cells.
  [[nodiscard]] int reach_cells() const { return reach_; }

 private:
  [[nodiscard]] float squared_cells(const Eigen::Vector3f& p_W) const;

  Eigen::Vector3f origin_ = Eigen::Vector3f::Zero();
  float cell_m_ = 0.02f, per_m_ = 50.0f, max_m_ = 0.0f;
  int nx_ = 0, ny_ = 0, nz_ = 0;  // corners, one more than cells
  int reach_ = 0;
  std::shared_ptr<const std::vector<std::int16_t>> squared_;  // copies of a field share it; nullptr: empty
};

}  // namespace colift::planner
