#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "hal/depth_camera.hpp"
#include "hal/lens.hpp"

namespace colift::hal::v4l2 {

/// What a file says of the camera, because the device does not.
struct DepthModel {
  CameraIntrinsics intrinsics;
  LensDistortion lens;
  double unit_m = 0.001;  ///< Depth of one unit of the image (m).
};

/// A picture of format Z16: rows of 16-bit little-endian words, 0 for none.
struct Z16View {
  std::span<const std::uint8_t> bytes;
  std::size_t stride = 0;  ///< Bytes from one row to the next.
};

/// Depths outside are not measured (m).
struct DepthRange {
  double min_m = 0.0, max_m = 29.0;
};

/// Bytes of a picture: the last row may end without its padding.
[[nodiscard]] constexpr std::size_t bytes_of(const CameraIntrinsics& size, std::size_t stride) {
  return stride * (static_cast<std::size_t>(size.height) - 1) + 2 * static_cast<std::size_t>(size.width);
}

/// Errors: BadConfig with the figure that cannot be: size, focal length, principal point, unit, a lens that
/// maps two rays to one pixel.
[[nodiscard]] Result<> check(const DepthModel& model);

/// Depth in metres along Cz, NaN where there is none, of the pinhole camera. The model is one that passes
/// check(). Errors: BadReply (stride or length contradict the size).
[[nodiscard]] Result<std::vector<float>> depth_of(const Z16View& picture, const DepthModel& model,
                                                  const DepthRange& range);

}  // namespace colift::hal::v4l2
