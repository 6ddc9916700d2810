#pragma once

#include <algorithm>

#include "planner/load_sharing/load_limits.hpp"

namespace colift::planner {

// The reduced problem of one pose: the partner's force z in [low, high], the torque  need - arm x z  left
// over for the wrists, both in the common frame. Without limits z = free + robot_part * (multiplier x arm).
struct LimitedSharing::Problem {
  Vec3 arm, need, low, high, free;

  Problem(const LimitedSharing& l, const Vec3& p1, const Vec3& p2, const Wrench& task)
      : arm(p1 - p2), need(task.torque - p2.cross(task.force)), free(l.sharing_.partner_part() * task.force) {
    for (int k = 0; k < 3; ++k) {
      low[k] = std::max(-l.limits_.partner.force_n, task.force[k] - l.limits_.robot.force_n);
      high[k] = std::min(l.limits_.partner.force_n, task.force[k] + l.limits_.robot.force_n);
      // both can touch: what is left of an interval of length zero after rounding is its middle
      if (low[k] > high[k]) low[k] = high[k] = 0.5 * (low[k] + high[k]);
    }
  }

  /// Size below which a residual torque is rounding.
  [[nodiscard]] double noise() const {
    return 1e-13 * (need.cwiseAbs().maxCoeff() + arm.cwiseAbs().maxCoeff() * free.cwiseAbs().maxCoeff());
  }

  [[nodiscard]] Vec3 clamp(const Vec3& z) const { return z.cwiseMax(low).cwiseMin(high); }
};

}  // namespace colift::planner
