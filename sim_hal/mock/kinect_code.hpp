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
inline constexpr int kKinectNoData = 2047;

/// Nearest code of a depth along Cz (m); kKinectNoData for NaN and what lies outside the table.
[[nodiscard]] inline int kinect_raw_code(float depth_m) {
  if (!(depth_m > 0.0f)) return kKinectNoData;
  const double raw = kKinectRawAtInfinity - kKinectK_mm / (1000.0 * static_cast<double>(depth_m));
  return raw > 0.0 && raw < 1088.0 ? static_cast<int>(raw + 0.5) : kKinectNoData;
}

/// Depth of a code (m), whole millimetres; NaN where the code is none.
[[nodiscard]] inline float kinect_depth_m(int raw) {
  static const auto table = [] {
    std::array<float, 1089> z{};
    for (std::size_t i = 0; i < z.size(); ++i)
      z[i] = static_cast<float>(std::trunc(kKinectK_mm / (kKinectRawAtInfinity - static_cast<double>(i))) /
                                1000.0);
    return z;
  }();
  return raw >= 0 && raw < static_cast<int>(table.size()) ? table[static_cast<std::size_t>(raw)]
                                                          : std::numeric_limits<float>::quiet_NaN();
}

/// Distance between neighbouring codes at a depth (m).
[[nodiscard]] constexpr double kinect_step_m(double depth_m) {
  return depth_m * depth_m / (kKinectK_mm / 1000.0);
}

}  // namespace colift::sim_hal
