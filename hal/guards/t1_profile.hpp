#pragma once

#include <algorithm>

#include "hal/guards/guarded_arm.hpp"

namespace colift::hal {

// In T1 (manual, reduced speed) the controller lets the flange move with 250 mm/s at most (ISO 10218-1), and
// stops an arm that is faster. Public drivers of the LWR 4+ keep each joint below 0.24 rad/s and 0.5 rad/s^2
// there (CentroEPiaggio/kuka-lwr, issue 85).
inline constexpr double kT1Velocity_rad_s = 0.24, kT1Acceleration_rad_s2 = 0.5, kT1Jerk_rad_s3 = 5.0;
inline constexpr double kT1Palm_m_s = 0.2;  ///< With a margin for what the hand adds to the flange.

/// The last gate in T1: no joint is commanded faster. Stops may brake as hard as ever.
[[nodiscard]] inline GuardConfig in_t1(GuardConfig guard) {
  guard.max_velocity_rad_s = std::min(guard.max_velocity_rad_s, kT1Velocity_rad_s);
  return guard;
}

}  // namespace colift::hal
