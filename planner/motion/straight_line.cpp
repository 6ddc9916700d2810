#include "planner/motion/straight_line.hpp"

#include <algorithm>
#include <cmath>

namespace colift::planner {
namespace {

/// Joints may turn so much in one step, however short it is (rad): it keeps rounding from looking like a
/// jump.
constexpr double kFreeTurn_rad = 0.02;

}  // namespace

double follow_line(const ArmGeometry& arm, const hal::Pose& X_WF, const hal::Vec3& shift_W, double step_m,
                   double margin_rad, double max_turn_rad_per_m, JointPath& path) {
  const double length = shift_W.norm();
  const int steps = std::max(1, static_cast<int>(std::ceil(length / step_m - 1e-9)));
  const double max_turn = std::max(kFreeTurn_rad, max_turn_rad_per_m * length / steps);
  hal::Pose X_WF_i = X_WF;
  for (int i = 1; i <= steps; ++i) {
    X_WF_i.translation() = X_WF.translation() + (static_cast<double>(i) / steps) * shift_W;
    const auto q = follow_ik(arm, X_WF_i, path.back(), margin_rad, max_turn);
    if (!q) return length * (i - 1) / steps;
    path.push_back(*q);
  }
  return length;
}

}  // namespace colift::planner
