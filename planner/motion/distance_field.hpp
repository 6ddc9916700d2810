#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "hal/types/geometry.hpp"
#include "perception/world_map.hpp"

namespace colift::planner {

/// Distance to the nearest obstacle cell on a grid, exact Euclidean between cell middles up to `max_m` and
/// cut there. distance() never says more than the true distance from p to the nearest point of any obstacle
/// cell.
class DistanceField {
 public:
  DistanceField() = default;
  /// `is_obstacle` is asked for every cell of the grid, in its order.
  DistanceField(const perception::CellGrid& grid, const std::vector<std::uint8_t>& is_obstacle,
                double max_m = 0.4);

  /// Lower bound of the distance (m); 0 inside obstacles. Outside of the grid: max_m, or the distance to the
  /// grid's obstacles if that is less.
  [[nodiscard]] float distance(const Eigen::Vector3f& p_W) const;

  [[nodiscard]] bool empty() const { return steps_.empty(); }

 private:
  Eigen::Vector3f origin_ = Eigen::Vector3f::Zero();
  float per_m_ = 1.0f, step_m_ = 0.0f, max_m_ = 0.0f, slack_m_ = 0.0f;
  int nx_ = 0, ny_ = 0, nz_ = 0;
  std::vector<std::uint16_t> steps_;
};

}  // namespace colift::planner
