#pragma once

#include <optional>
#include <string>

#include "hal/depth_camera.hpp"
#include "hal/drivers/recorded/file_bytes.hpp"
#include "hal/lens.hpp"

namespace colift::hal {

/// What a camera.json says about a depth image.
struct CameraFile {
  double fx = 0.0, fy = 0.0, cx = 0.0,
         cy = 0.0;             ///< Pinhole model (pixels), pixel centres at integer coordinates.
  double depth_scale_m = 0.0;  ///< Depth of one unit of the image (m).
  LensDistortion lens;
  std::optional<int> width, height;  ///< Size of the image, when the file gives it (pixels).

  /// The model for an image of the given size.
  [[nodiscard]] CameraIntrinsics intrinsics(int image_width, int image_height) const {
    return {image_width, image_height, fx, fy, cx, cy};
  }
};

/// Parses camera.json: an object with the numbers fx, fy, cx, cy, depth_scale_m and, if it likes, width,
/// height and distortion: 4, 5 or 8 numbers in OpenCV's order k1 k2 p1 p2 k3 k4 k5 k6, or {"model": "none" |
/// "brown-conrady" | "rational", "coefficients": [...]}; other keys are left alone. Errors: BadInput, at
/// line:column for a syntax error and at the key otherwise.
[[nodiscard]] Result<CameraFile> parse_camera_json(Bytes bytes, const std::string& name);

}  // namespace colift::hal
