#include <cmath>

#include <algorithm>
#include "planner/motion/trajectory/trajectory_maker.hpp"
#include "planner/motion/trajectory/trajectory_profile.hpp"

namespace colift::planner {
namespace {

using hal::JointVector;

/// Lengths are in seconds: of a motion at the velocity limit of the joint that takes longest. Speed 1 is then
/// full speed everywhere.
struct Leg {
  JointVector from, direction;  ///< rad, rad per s of length.
  double length_s = 0.0;
  SpeedLimits limits;
};

/// The corner before a leg: the direction turns in a ramp, at constant speed, from a reach before it to a
/// reach after it.
struct Corner {
  double speed = 0.0;
  double turn_acceleration = 0.0,
         turn_jerk = 0.0;  ///< At speed 1; limits of the ramp are these by the speed.

  [[nodiscard]] SpeedRamp ramp(double at_speed) const {
    return speed_ramp(0.0, 1.0, {1.0, turn_acceleration / at_speed, turn_jerk / at_speed});
  }
  [[nodiscard]] double reach_s() const { return speed > 0.0 ? 0.5 * speed * ramp(speed).duration_s() : 0.0; }
};

/// Straight ways between turns of the path; points that lie on a straight way are left out.
std::vector<Leg> legs_of(std::span<const JointVector> path, const MotionLimits& limits) {
  constexpr double kSameDirection = 1e-9;  // rounding
  std::vector<Leg> legs;
  const auto leg = [&](const JointVector& from, const JointVector& to) {
    Leg out;
    out.from = from;
    out.length_s = ((to - from).array() / limits.velocity_rad_s.array()).abs().maxCoeff();
    if (out.length_s > 0.0) out.direction = (to - from) / out.length_s;
    return out;
  };
  for (std::size_t i = 1; i < path.size(); ++i) {
    const Leg next = leg(path[i - 1], path[i]);
    if (!(next.length_s > 0.0)) continue;
    const JointVector from = legs.empty() ? path[0] : path[i - 1];
    if (!legs.empty() &&
        (next.direction - legs.back().direction).cwiseAbs().cwiseQuotient(limits.velocity_rad_s).maxCoeff() <
            kSameDirection) {
      legs.back() = leg(legs.back().from, path[i]);
    } else {
      legs.push_back(leg(from, path[i]));
    }
  }
  for (Leg& l : legs) {
    const JointVector d = l.direction.cwiseAbs().cwiseMax(1e-300);
    l.limits = {1.0, limits.acceleration_rad_s2.cwiseQuotient(d).minCoeff(),
                limits.jerk_rad_s3.cwiseQuotient(d).minCoeff()};
  }
  return legs;
}

/// As fast as reach and blend allow. Both grow with the speed, so the corner only gets sharper when the legs
/// beside it force it to be slower.
Corner corner_between(const Leg& before, const Leg& after, const MotionLimits& limits, double blend_rad) {
  // some of each leg stays straight: only there the speed changes
  constexpr double kMostOfLeg = 0.4;
  const double room_s = kMostOfLeg * std::min(before.length_s, after.length_s);
  const JointVector turn = (after.direction - before.direction).cwiseAbs().cwiseMax(1e-300);
  Corner corner;
  corner.turn_acceleration = limits.acceleration_rad_s2.cwiseQuotient(turn).minCoeff();
  corner.turn_jerk = limits.jerk_rad_s3.cwiseQuotient(turn).minCoeff();
  corner.speed = last_that_holds(0.0, 1.0, [&](double speed) {
    const SpeedRamp r = corner.ramp(speed);
    // the corner is missed most in the middle of the ramp: by the integral of its first half
    const double t = r.jerk_s, c = r.constant_s;
    const double missed = (t * t / 6.0 + t * c / 4.0 + c * c / 8.0) / (t + c);
    return speed * missed * turn.maxCoeff() <= blend_rad && 0.5 * speed * r.duration_s() <= room_s;
  });
  constexpr double kStop = 1e-6;  // slower than this is standstill: it guards the division by the speed
  if (corner.speed < kStop) corner.speed = 0.0;
  return corner;
}

void append_straight(TrajectoryMaker& maker, const Leg& leg, double from_s, const SpeedProfile& profile) {
  double s = from_s, v = profile.start_velocity, a = 0.0;
  for (const auto& phase : profile.phases) {
    const double t = phase.duration_s, j = phase.jerk;
    maker.append(t, {leg.from + s * leg.direction, v * leg.direction, a * leg.direction}, j * leg.direction);
    s += t * (v + t * (0.5 * a + t * j / 6.0));
    v += t * (a + 0.5 * t * j);
    a += t * j;
  }
}

void append_corner(TrajectoryMaker& maker, const Leg& before, const Leg& after, const Corner& corner) {
  if (!(corner.speed > 0.0)) return;
  const double v = corner.speed;
  const SpeedRamp ramp = corner.ramp(v);
  const JointVector jerk = (v * ramp.jerk) * (after.direction - before.direction);
  maker.append(ramp.jerk_s,
               {after.from - corner.reach_s() * before.direction, v * before.direction, JointVector::Zero()},
               jerk);
  maker.append(ramp.constant_s, maker.end(), JointVector::Zero());
  maker.append(ramp.jerk_s, maker.end(), -jerk);
}

}  // namespace

hal::Result<Trajectory> make_trajectory(std::span<const JointVector> path, const MotionLimits& limits,
                                        double blend_rad) {
  if (auto ok = check_path(path, limits); !ok) return tl::unexpected(ok.error());
  if (!(blend_rad >= 0.0)) {
    return hal::failure(hal::ErrorCode::BadInput, "trajectory", "the blend of corners is not 0 or more");
  }
  const std::vector<Leg> legs = legs_of(path, limits);
  TrajectoryMaker maker(path.front());
  if (legs.empty()) return std::move(maker).finish(path.back());

  // corner i lies before leg i; the first and the last are start and goal
  std::vector<Corner> corners(legs.size() + 1);
  for (std::size_t i = 1; i < legs.size(); ++i)
    corners[i] = corner_between(legs[i - 1], legs[i], limits, blend_rad);
  const auto straight_s = [&](std::size_t i) {
    return std::max(0.0, legs[i].length_s - corners[i].reach_s() - corners[i + 1].reach_s());
  };
  for (std::size_t i = 0; i < legs.size(); ++i) {
    corners[i + 1].speed =
        std::min(corners[i + 1].speed, reachable_velocity(corners[i].speed, straight_s(i), legs[i].limits));
  }
  for (std::size_t i = legs.size(); i-- > 0;) {
    corners[i].speed =
        std::min(corners[i].speed, reachable_velocity(corners[i + 1].speed, straight_s(i), legs[i].limits));
  }
  for (std::size_t i = 0; i < legs.size(); ++i) {
    if (i > 0) append_corner(maker, legs[i - 1], legs[i], corners[i]);
    append_straight(maker, legs[i], corners[i].reach_s(),
                    fastest_profile(straight_s(i), corners[i].speed, corners[i + 1].speed, legs[i].limits));
  }
  return std::move(maker).finish(path.back());
}

}  // namespace colift::planner
