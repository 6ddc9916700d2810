#pragma once

#include <numbers>

namespace colift::hal {

// Function and factor may differ in the last bit. Where that bit could reach a motion (a margin that bounds
// random postures, a yaw given in degrees), a place keeps the one it has, so that recorded lifts replay bit
// for bit. Vectors are multiplied by the factor.

[[nodiscard]] constexpr double deg_to_rad(double deg) {
  return deg * std::numbers::pi / 180.0;
}
[[nodiscard]] constexpr double rad_to_deg(double rad) {
  return rad * 180.0 / std::numbers::pi;
}
inline constexpr double kRadPerDeg = std::numbers::pi / 180.0, kDegPerRad = 180.0 / std::numbers::pi;

}  // namespace colift::hal
