#pragma once

#include <cstddef>
#include <cstdint>

namespace colift::hal::kinect {

// What every Kinect v1 has in common (OpenKinect/libfreenect 0.5.3).
inline constexpr int kWidth = 640, kHeight = 480;
inline constexpr int kInfraredHeight = 488;  ///< Eight rows more than the depth.
inline constexpr std::size_t kPixels = 640UL * 480, kInfraredPixels = 640UL * 488;
inline constexpr std::uint16_t kNoDepth = 2047;       ///< Raw code of a pixel that saw nothing.
inline constexpr std::uint16_t kMostInfrared = 1023;  ///< Ten bits.
inline constexpr double kTicksPerSecond = 60e6;       ///< Of the device's 32-bit counter: wraps after 71.6 s.
inline constexpr double kCountsPerG = 819.0;          ///< Of the accelerometer.
inline constexpr double kTilt_deg = 31.0;             ///< The motor's way to either side.

}  // namespace colift::hal::kinect
