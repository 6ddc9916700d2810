#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "hal/device.hpp"
#include "hal/types/geometry.hpp"
#include "hal/types/time.hpp"

namespace colift::hal {

/// Pinhole model without distortion, in pixels; pixel centres at integer coordinates.
struct CameraIntrinsics {
  int width = 640;
  int height = 480;
  double fx = 575.8;  ///< Kinect v1, unregistered: reference distance / (2 pixel size).
  double fy = 575.8;
  double cx = 320.0;
  double cy = 240.0;
};

/// One depth image. Optical frame C: Cz looks forward, Cx right, Cy down.
struct DepthFrame {
  Timestamp exposed_at{0};  ///< When the light was measured, not when the bytes arrived.
  CameraIntrinsics intrinsics;
  std::vector<float> depth_m;  ///< width * height, row-major, metres along Cz; NaN where nothing was seen.
  std::vector<std::uint8_t>
      rgb;                   ///< 3 * width * height, row-major, aligned with the depth; empty when unknown.
  std::optional<Vec3> up_C;  ///< Unit vector against gravity (accelerometer), when the device has one.
};

/// Kinect, simulation, mock and recording all look like this to the rest of CoLift.
class DepthCamera : public Device {
 public:
  /// Waits for a frame newer than the last one returned.
  /// Errors: Timeout (none within `timeout`), LinkLost (unplugged or end of recording; configure() again).
  /// Call from one thread only. Allocates, so keep it off the real-time thread.
  [[nodiscard]] virtual Result<DepthFrame> next_frame(std::chrono::milliseconds timeout) = 0;
};

}  // namespace colift::hal
