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

/// A camera that can also show the infrared light which it measures depth with: for calibration.
class InfraredCamera {
 public:
  virtual ~InfraredCamera() = default;

  /// Lets infrared images come beside the depth, or no more. Errors: NotReady (not open), DeviceFault (it has
  /// none, as a recording of depth alone).
  [[nodiscard]] virtual Result<> want_infrared(bool wanted) = 0;

  /// Waits for an image newer than the last one returned. Errors: those of DepthCamera::next_frame(), and
  /// NotReady where none were asked for. The same thread as next_frame().
  [[nodiscard]] virtual Result<InfraredFrame> next_infrared(std::chrono::milliseconds patience) = 0;
};

}  // namespace colift::hal
