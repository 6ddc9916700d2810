#pragma once

#include <cstdint>
#include <vector>

namespace colift::planner {

/// Numbers of cells of a grid, x fastest.
struct GridSize {
  int nx = 0, ny = 0, nz = 0;
};

/// Longest reach of squared_distances(): its square has to fit 16 bits.
inline constexpr int kMaxReach_cells = 181;

/// Squared distance, in cells, from each corner of the grid's cells to the nearest obstacle cell, cut at the
/// square of `reach` cells (1 to kMaxReach_cells). (nx + 1)(ny + 1)(nz + 1) values, x fastest, all exact.
/// `is_obstacle` holds 0 or 1 for every cell.
[[nodiscard]] std::vector<std::int16_t> squared_distances(const GridSize& size,
                                                          const std::vector<std::uint8_t>& is_obstacle,
                                                          int reach);

}  // namespace colift::planner
