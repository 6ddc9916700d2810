#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include "hal/types/geometry.hpp"

namespace colift::hal {

/// The points of a PCD or PLY file, in the file's own frame F.
struct PointFile {
  int width = 0;
  int height = 0;  ///< 1: an unorganised list of points.
  std::vector<float> x, y,
      z;  ///< width * height values each (m), row-major; not finite where nothing was seen.
  std::vector<std::uint8_t> rgb;  ///< 3 * width * height, or empty when the file has no colours.
  Pose viewpoint =
      Pose::Identity();  ///< Pose of the sensor in F as the file states it; identity when it does not.

  [[nodiscard]] std::size_t size() const { return x.size(); }
  [[nodiscard]] bool organised() const { return height > 1; }

  /// True where the file holds a point. Some writers put (0, 0, 0) where others put NaN; nothing can be seen
  /// there.
  [[nodiscard]] bool seen(std::size_t i) const {
    return std::isfinite(x[i]) && std::isfinite(y[i]) && std::isfinite(z[i]) &&
           (x[i] != 0.0f || y[i] != 0.0f || z[i] != 0.0f);
  }
};

/// A coordinate as it is kept (m). A double beyond a float is no distance that anyone measured: NaN.
[[nodiscard]] inline float to_coordinate(double value_m) {
  return std::abs(value_m) <= double{std::numeric_limits<float>::max()}
             ? static_cast<float>(value_m)
             : std::numeric_limits<float>::quiet_NaN();
}

}  // namespace colift::hal
