#include "planner/motion/straight_line.hpp"

#include <algorithm>
#include <cmath>

namespace colift::planner {
namespace {

/// Joints may turn so much per metre of the hand (rad/m); more is a jump near a singularity.
constexpr double kMaxTurnPerMetre = 20.0;

}  // namespace

double follow_line(const ArmGeometry& arm, const hal::Pose& X_WF, const hal::Vec3& shift_W, double step_m,
                   double margin_rad, JointPath& path) {
  const double length = shift_W.norm();
  const int steps = std::max(1, static_cast<int>(std::ceil(length / step_m - 1e-9)));
  const double max_turn = std::max(0.02, kMaxTurnPerMetre * length / steps);
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
