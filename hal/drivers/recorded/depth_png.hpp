#pragma once

#include <string>
#include <vector>

#include "hal/drivers/recorded/file_bytes.hpp"

namespace colift::hal {

/// A depth image as it lies in a file.
struct DepthImage {
  int width = 0;
  int height = 0;
  std::vector<float> depth_m;  ///< width * height, row-major; NaN where the file has 0 ("no data").
};

/// Parses a 16-bit grey PNG, interlaced or not; `depth_scale_m` is the depth of one unit (m).
/// Errors: BadInput (another kind of image, damaged, truncated, no pixels; larger than 8192 x 8192).
[[nodiscard]] Result<DepthImage> parse_depth_png(Bytes bytes, const std::string& name, double depth_scale_m);

}  // namespace colift::hal
