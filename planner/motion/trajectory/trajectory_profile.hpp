#pragma once

#include <array>

namespace colift::planner {

/// Largest x in [low, high] that still holds, for something that holds up to a point; `low` holds.
template <class Holds>
double last_that_holds(double low, double high, Holds holds) {
  if (holds(high)) return high;
  for (int i = 0; i < 100; ++i) {
    const double middle = 0.5 * (low + high);
    if (middle <= low || middle >= high) break;
    (holds(middle) ? low : high) = middle;
  }
  return low;
}

/// Limits of a motion along a path, in any unit of length.
struct SpeedLimits {
  double velocity = 1.0, acceleration = 1.0, jerk = 1.0;
};

/// A change of speed: jerk, constant acceleration, jerk back.
struct SpeedRamp {
  double jerk_s = 0.0, constant_s = 0.0;
  double jerk = 0.0;  ///< Signed.

  [[nodiscard]] double duration_s() const { return 2.0 * jerk_s + constant_s; }
};
/// In the shortest time, without acceleration at both ends.
[[nodiscard]] SpeedRamp speed_ramp(double from_velocity, double to_velocity, const SpeedLimits& limits);

/// Seven phases of constant jerk along a straight line ("double S"): without acceleration at both ends, at
/// the given speeds there, in the shortest time.
struct SpeedProfile {
  struct Phase {
    double duration_s = 0.0, jerk = 0.0;
  };
  std::array<Phase, 7> phases{};
  double start_velocity = 0.0;

  [[nodiscard]] double duration_s() const;
};

/// Distance that a change of speed takes.
[[nodiscard]] double ramp_distance(double from_velocity, double to_velocity, const SpeedLimits& limits);

/// Highest speed up to the limit that can be reached from (or left to) a lower one within a distance.
[[nodiscard]] double reachable_velocity(double from_velocity, double distance, const SpeedLimits& limits);

/// `distance` must be at least the ramp distance between the two speeds, and both within the limit.
[[nodiscard]] SpeedProfile fastest_profile(double distance, double from_velocity, double to_velocity,
                                           const SpeedLimits& limits);

}  // namespace colift::planner
