#pragma once

#include <array>
#include <cmath>
#include <limits>

namespace colift::sim_hal {

// Depth of a Kinect v1 from its 11-bit raw code, with the nominal constants of the device (emitter
// distance 7.5 cm, reference plane 120 cm, pixel 0.1042 mm on it, constant shift 200; OpenKinect/libfreenect,
// registration): z_mm = trunc(K / (raw_inf - raw)). Recorded clouds of real devices hold only these values.
inline constexpr double kKinectK_mm = 345489.4;
inline constexpr double kKinectRawAtInfinity = 1089.408;
inline constexpr int kKinectCodes = 1089;  ///< From 0; those with a depth.

/// Depth of every code (m), whole millimetres, one place up: NaN stands at both ends, for what has no code.
[[nodiscard]] inline const std::array<float, kKinectCodes + 2>& kinect_depths_m() {
  static const auto table = [] {
    std::array<float, kKinectCodes + 2> z{};
    z.front() = z.back() = std::numeric_limits<float>::quiet_NaN();
    for (int raw = 0; raw < kKinectCodes; ++raw)
      z[static_cast<std::size_t>(raw) + 1] =
          static_cast<float>(std::trunc(kKinectK_mm / (kKinectRawAtInfinity - raw)) / 1000.0);
    return z;
  }();
  return table;
}

}  // namespace colift::sim_hal
