#pragma once

#include <algorithm>
#include <cmath>

namespace colift::hal {

/// Limits of one joint. The position range is where commands may be; acceleration also counts for stopping.
struct JointBounds {
  double lower_rad = 0.0, upper_rad = 0.0, velocity_rad_s = 0.0, acceleration_rad_s2 = 0.0;
};

/// Greatest velocity for a step of dt_s after which a joint, braking with `acceleration`, still comes to rest
/// within `distance` of where the step began: v dt + v^2 / 2a = distance. Holds for any later steps, since in
/// steps of dt a joint needs at most v^2 / 2a to stop (its velocity falls before it moves). 0 beyond the end.
[[nodiscard]] inline double stoppable_speed(double distance, double dt_s, double acceleration) {
  if (distance <= 0.0) return 0.0;
  return acceleration * (std::sqrt(dt_s * dt_s + 2.0 * distance / acceleration) - dt_s);
}

struct VelocityRange {
  double low, high;
};

/// Velocities that the next step may have, so that position, velocity and acceleration keep their limits and
/// a rest before the position limits stays possible for ever. Never empty when (q, dq) itself came from here
/// or is at rest; a joint at rest outside its range may only move inwards.
[[nodiscard]] inline VelocityRange allowed_velocity(double q_rad, double dq_rad_s, double dt_s,
                                                    const JointBounds& b) {
  const double change = b.acceleration_rad_s2 * dt_s;
  const double up =
      std::min(b.velocity_rad_s, stoppable_speed(b.upper_rad - q_rad, dt_s, b.acceleration_rad_s2));
  const double down =
      -std::min(b.velocity_rad_s, stoppable_speed(q_rad - b.lower_rad, dt_s, b.acceleration_rad_s2));
  const double low = std::max(down, dq_rad_s - change);
  return {low, std::max(low, std::min(up, dq_rad_s + change))};
}

/// The velocity of the next step on the way to rest.
[[nodiscard]] inline double braking_velocity(double q_rad, double dq_rad_s, double dt_s,
                                             const JointBounds& b) {
  const VelocityRange allowed = allowed_velocity(q_rad, dq_rad_s, dt_s, b);
  return std::clamp(0.0, allowed.low, allowed.high);
}

}  // namespace colift::hal
