#pragma once

#include "hal/types/joints.hpp"
#include "hal/types/units.hpp"

namespace colift::hal {

// What a KUKA LWR 4+ can do and its controller takes, for checks at the wire. Positions: all public
// descriptions agree. Velocities: the row of the data sheet (110 110 128 128 204 184 184 deg/s), as in
// CentroEPiaggio's kuka-lwr. Torques: the same source. Gains: the interface's manual as cited in public.

inline constexpr double kLwrMaxStiffness_nm_rad = 2000.0;
inline constexpr double kLwrMaxCartStiffness_n_m = 5000.0, kLwrMaxCartStiffness_nm_rad = 300.0;
inline constexpr double kLwrPayloadForce_n = 300.0, kLwrPayloadTorque_nm = 100.0;

[[nodiscard]] inline JointVector lwr_limit_rad() {
  JointVector v;
  v << 170, 120, 170, 120, 170, 120, 170;
  return v * kRadPerDeg;
}

[[nodiscard]] inline JointVector lwr_velocity_rad_s() {
  JointVector v;
  v << 110, 110, 128, 128, 204, 184, 184;
  return v * kRadPerDeg;
}

[[nodiscard]] inline JointVector lwr_torque_nm() {
  JointVector v;
  v << 176, 176, 100, 100, 100, 38, 38;
  return v;
}

}  // namespace colift::hal
