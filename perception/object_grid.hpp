#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "hal/types/geometry.hpp"

namespace colift::perception {

/// Which part of the object is nearest to a point of space, answered by one look-up. The object's points are
/// gathered into small cells ("patches", one mean point each); every cell of space within `reach_m` of the
/// object knows its nearest patch. Built once for a reference (a few ms), read for every changed pixel of
/// every frame (a few ns).
class ObjectGrid {
 public:
  static constexpr std::int32_t kNone = std::numeric_limits<std::int32_t>::max();

  /// Points in W (m), NaN ignored. The cell grows beyond `cell_m` when the object is so large that the grid
  /// would exceed two million cells.
  ObjectGrid(std::span<const Eigen::Vector3f> points, double cell_m, double reach_m);

  /// Patch nearest to a point; kNone when the object is farther than about reach_m, or the point is NaN.
  [[nodiscard]] std::int32_t nearest(float x, float y, float z) const {
    // as unsigned, "below zero" is "too large": one comparison for each axis; NaN fails the range test
    const float fx = (x - origin_.x()) * per_cell_, fy = (y - origin_.y()) * per_cell_,
                fz = (z - origin_.z()) * per_cell_;
    if (!(fx >= 0.0F && fy >= 0.0F && fz >= 0.0F)) return kNone;
    if (!(fx < size_f_[0] && fy < size_f_[1] && fz < size_f_[2])) return kNone;
    return nearest_[cell(static_cast<int>(fx), static_cast<int>(fy), static_cast<int>(fz))];
  }

  [[nodiscard]] const std::vector<Eigen::Vector3f>& patches() const { return patches_; }
  [[nodiscard]] double cell_m() const { return 1.0 / static_cast<double>(per_cell_); }
  [[nodiscard]] double reach_m() const { return reach_m_; }

 private:
  [[nodiscard]] std::size_t cell(int ix, int iy, int iz) const {
    return (static_cast<std::size_t>(iz) * static_cast<std::size_t>(size_[1]) +
            static_cast<std::size_t>(iy)) *
               static_cast<std::size_t>(size_[0]) +
           static_cast<std::size_t>(ix);
  }
  void spread_from_patches(const std::vector<std::uint32_t>& first);

  double reach_m_;
  float per_cell_ = 0.0F;
  Eigen::Vector3f origin_ = Eigen::Vector3f::Zero();
  std::array<int, 3> size_{};
  std::array<float, 3> size_f_{};
  std::vector<std::int32_t> nearest_;
  std::vector<Eigen::Vector3f> patches_;
};

}  // namespace colift::perception
