#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "perception/map/world_map.hpp"

namespace colift::planner {

/// Squared distances (cells^2) of the corners of a box of cells to obstacles in it, as squared_distances()
/// has them. Empty without obstacles.
struct BoxDistances {
  Eigen::Vector3i first = Eigen::Vector3i::Zero(), size = Eigen::Vector3i::Zero();  ///< Cells of the grid.
  std::vector<std::int16_t> squared;
};

/// Which cells of a grid are near to points: those whose nearest point comes within a radius of a cell with a
/// point in it. One distance transform of the points' surroundings, however many they are.
class NearPoints {
 public:
  /// `points` in W, up to `max_radius_m` outside of the grid too; those farther away do not matter. The
  /// radius is cut at kMaxReach_cells.
  NearPoints(const perception::CellGrid& grid, std::span<const Eigen::Vector3f> points, double max_radius_m);

  /// Whether no point is near enough to matter.
  [[nodiscard]] bool empty() const { return to_points_.squared.empty(); }
  /// Whether a cell of the grid is within `radius_m` (0 to max_radius_m).
  [[nodiscard]] bool reach(const Eigen::Vector3i& cell, double radius_m) const;
  /// Distances to the grid's cells within `radius_m`, in a box `reach` cells beyond them, cut at the grid.
  [[nodiscard]] BoxDistances distances_to(double radius_m, int reach) const;

 private:
  /// Squared distance (cells^2) of a cell within the box; cut at the reach.
  [[nodiscard]] std::int16_t squared(const Eigen::Vector3i& cell) const;
  [[nodiscard]] double limit(double radius_m) const { return radius_m * radius_m / (cell_m_ * cell_m_); }

  Eigen::Vector3i count_;  // cells of the grid
  double cell_m_;
  Eigen::Vector3i points_low_ = Eigen::Vector3i::Zero(),
                  points_high_ = Eigen::Vector3i::Zero();  // their cells
  BoxDistances to_points_;                                 // may reach beyond the grid
};

}  // namespace colift::planner
