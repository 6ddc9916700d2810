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
/// Of physics, of the arm's model, and of everything that turns a mass into a load or a load into a mass: one
/// figure, so that what is predicted can be compared with what is measured. MuJoCo's own default.
inline constexpr double kGravity_m_s2 = 9.81;

inline constexpr double kRadPerDeg = std::numbers::pi / 180.0, kDegPerRad = 180.0 / std::numbers::pi;

}  // namespace colift::hal
