#pragma once

#include <optional>
#include <vector>

namespace colift::hal {

/// One axis of a pixel grid: pixel = focal * tangent + centre is a whole number for (nearly) every point.
struct PixelGrid {
  double focal = 0.0;   ///< Pixels per unit of tangent.
  double centre = 0.0;  ///< Pixel of tangent 0.
  int count = 0;        ///< Pixels from the first to the last point; the first is pixel 0.
};

/// Finds the pixel grid that the tangents x/z (or y/z) of some points came from, if there is one: the focal
/// length between 0.8 and 1.6 times the estimate at which exp(2 pi i f a) adds up over the points instead of
/// cancelling out. Nothing when the points are not on a grid (voxel filtered, several views, noise across the
/// ray). Deterministic.
[[nodiscard]] std::optional<PixelGrid> find_pixel_grid(const std::vector<float>& tangents,
                                                       double focal_estimate);

}  // namespace colift::hal
