#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "sim_hal/synthetic/ray_caster.hpp"

namespace colift::sim_hal {

/// One bit per pixel.
class PixelSet {
 public:
  PixelSet(int width, int height);

  void insert(int u, int v) { row(v)[u / 64] |= std::uint64_t{1} << (u % 64); }
  /// All pixels within `reach` columns and rows of one of this set; at most 63.
  [[nodiscard]] PixelSet grown(int reach) const;
  [[nodiscard]] std::size_t count() const;

  /// Runs f(u, v, index in the image) for every pixel, in image order.
  template <class F>
  void for_each(F f) const {
    for (int v = 0; v < height_; ++v) for_each_in_row(v, f);
  }
  /// The same for one row.
  template <class F>
  void for_each_in_row(int v, F f) const {
    for (int w = 0; w < words_; ++w)
      for (std::uint64_t left = row(v)[w]; left != 0; left &= left - 1) {
        const int u = 64 * w + std::countr_zero(left);
        f(u, v, static_cast<std::size_t>(v) * static_cast<std::size_t>(width_) + static_cast<std::size_t>(u));
      }
  }

 private:
  [[nodiscard]] std::uint64_t* row(int v) { return &bits_[static_cast<std::size_t>(v * words_)]; }
  [[nodiscard]] const std::uint64_t* row(int v) const { return &bits_[static_cast<std::size_t>(v * words_)]; }

  int width_, height_, words_;  // words: of one row
  std::vector<std::uint64_t> bits_;
};

/// Pixels on both sides of a jump in depth by `jump_m` or more, or of an end of all surfaces. Shapes are
/// convex, so depth jumps only where the shape changes.
[[nodiscard]] PixelSet find_edges(const Rendering& truth, float jump_m);

}  // namespace colift::sim_hal
