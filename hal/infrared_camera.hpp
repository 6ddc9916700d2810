#pragma once

#include <chrono>
#include <cstdint>
#include <vector>

#include "hal/depth_camera.hpp"

namespace colift::hal {

/// One infrared image, of the same lens as the depth. Optical frame C as in DepthFrame.
struct InfraredFrame {
  Timestamp exposed_at{0};      ///< When the light was measured; the clock of DepthFrame.
  CameraIntrinsics intrinsics;  ///< Of this image, not of the depth image.
  int width = 0;
  int height = 0;
  std::vector<std::uint16_t> brightness;  ///< width * height, row-major; 0 to 1023.
};

/// Pixel (u, v) of a Kinect's depth image looks where pixel (u + 5, v + 4) of its infrared image looks: half
/// a correlation window (freenect_camera). The infrared image has eight rows more.
inline constexpr int kInfraredColumns = 5, kInfraredRows = 4;
/// Intrinsics of the infrared image that belongs to a depth image, and back.
[[nodiscard]] inline CameraIntrinsics infrared_of(const CameraIntrinsics& depth) {
  return {depth.width, depth.height + 2 * kInfraredRows, depth.fx,
          depth.fy,    depth.cx + kInfraredColumns,      depth.cy + kInfraredRows};
}
[[nodiscard]] inline CameraIntrinsics depth_of(const CameraIntrinsics& infrared) {
  return {infrared.width, infrared.height - 2 * kInfraredRows, infrared.fx,
          infrared.fy,    infrared.cx - kInfraredColumns,      infrared.cy - kInfraredRows};
}

/// A camera that can also show the infrared light which it measures depth with: for calibration.
class InfraredCamera {
 public:
  virtual ~InfraredCamera() = default;

  /// Lets infrared images come beside the depth, or no more. Errors: NotReady (not open), DeviceFault (it has
  /// none, as a recording of depth alone).
  [[nodiscard]] virtual Result<> want_infrared(bool wanted) = 0;

  /// Waits for an image newer than the last one returned. Errors: those of DepthCamera::next_frame(), and
  /// NotReady where none were asked for. The same thread as next_frame().
  [[nodiscard]] virtual Result<InfraredFrame> next_infrared(std::chrono::milliseconds timeout) = 0;
};

}  // namespace colift::hal
