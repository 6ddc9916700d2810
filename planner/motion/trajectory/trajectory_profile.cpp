#include "planner/motion/trajectory/trajectory_profile.hpp"

#include <algorithm>
#include <cmath>

namespace colift::planner {
SpeedRamp speed_ramp(double from, double to, const SpeedLimits& limits) {
  const double change = std::abs(to - from);
  SpeedRamp r;
  r.jerk = to >= from ? limits.jerk : -limits.jerk;
  if (change * limits.jerk <= limits.acceleration * limits.acceleration) {
    r.jerk_s = std::sqrt(change / limits.jerk);
  } else {
    r.jerk_s = limits.acceleration / limits.jerk;
    r.constant_s = change / limits.acceleration - r.jerk_s;
  }
  return r;
}

double SpeedProfile::duration_s() const {
  double sum = 0.0;
  for (const Phase& phase : phases) sum += phase.duration_s;
  return sum;
}

double ramp_distance(double from, double to, const SpeedLimits& limits) {
  return 0.5 * (from + to) * speed_ramp(from, to, limits).duration_s();
}

double reachable_velocity(double from, double distance, const SpeedLimits& limits) {
  return last_that_holds(from, std::max(from, limits.velocity),
                         [&](double v) { return ramp_distance(from, v, limits) <= distance; });
}

SpeedProfile fastest_profile(double distance, double from, double to, const SpeedLimits& limits) {
  const double lowest = std::max(from, to);
  const auto ramps = [&](double v) { return ramp_distance(from, v, limits) + ramp_distance(v, to, limits); };
  const double top = last_that_holds(lowest, std::max(lowest, limits.velocity),
                                     [&](double v) { return ramps(v) <= distance; });
  const SpeedRamp up = speed_ramp(from, top, limits), down = speed_ramp(top, to, limits);
  const double rest = std::max(0.0, distance - ramps(top));
  SpeedProfile profile;
  profile.start_velocity = from;
  profile.phases = {{{up.jerk_s, up.jerk},
                     {up.constant_s, 0.0},
                     {up.jerk_s, -up.jerk},
                     {top > 0.0 ? rest / top : 0.0, 0.0},
                     {down.jerk_s, down.jerk},
                     {down.constant_s, 0.0},
                     {down.jerk_s, -down.jerk}}};
  return profile;
}

}  // namespace colift::planner
