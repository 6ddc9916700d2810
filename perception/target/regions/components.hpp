#pragma once

#include <cstdint>
#include <vector>

namespace colift::perception {

/// Connected regions of a masked depth image.
struct Components {
  /// Pixels first..last of a row, all of one region; row by row, from left to right.
  struct Run {
    int row, first, last;
    std::int32_t label;
  };
  std::vector<Run> runs;
  std::vector<std::uint32_t> pixels;  ///< Number of pixels of each region.
  static constexpr std::int32_t kNone = -1;

  /// Region of every pixel, kNone outside the mask.
  [[nodiscard]] std::vector<std::int32_t> labels(int width, int height) const;
};

/// Depth difference up to which two neighbouring pixels may lie on one surface: base + growth * depth^2 (m).
struct DepthJump {
  float base_m = 0.02f;
  float growth_per_m = 0.0f;

  [[nodiscard]] bool same_surface(float a_m, float b_m) const {
    const float near_m = a_m < b_m ? a_m : b_m;
    const float difference = a_m < b_m ? b_m - a_m : a_m - b_m;
    return difference <= base_m + growth_per_m * near_m * near_m;
  }
};

/// Regions of pixels whose mask is 1 (and not 0) that hang together over 8-neighbours without a depth jump.
/// One pass over runs with union-find; regions are numbered by their first pixel, row by row.
[[nodiscard]] Components connected_components(const std::vector<float>& depth_m,
                                              const std::vector<std::uint8_t>& mask, int width, int height,
                                              const DepthJump& jump);

}  // namespace colift::perception
