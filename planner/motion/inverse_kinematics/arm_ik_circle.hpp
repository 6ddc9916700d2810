#pragma once

#include <array>
#include <optional>

#include "planner/motion/inverse_kinematics/arm_ik.hpp"

namespace colift::planner {

/// The circle on which the elbow can stand for one pose of the flange, and what does not depend on where:
/// with e(psi) = cos(psi) u + sin(psi) v the upper arm points along cos(lean) n + sin(lean) e.
struct ElbowCircle {
  Eigen::Matrix3d R_WF = Eigen::Matrix3d::Identity();
  hal::Vec3 n, u, v;      ///< Shoulder to wrist, up across it, n x u; unit vectors in W.
  double bend_rad = 0.0;  ///< |A4|.
  double sin_bend = 0.0, cos_bend = 1.0;
  double sin_lean = 0.0, cos_lean = 1.0;  ///< Of the upper arm against n.
};

/// nullopt when the wrist is too far or too near, or the pose is not finite.
[[nodiscard]] std::optional<ElbowCircle> elbow_circle(const ArmGeometry& arm, const hal::Pose& X_WF);

/// The up direction across a unit vector n; towards Wx where n is vertical.
[[nodiscard]] hal::Vec3 up_across(const hal::Vec3& n);

/// Direction from the line shoulder-wrist to the elbow. A straight arm still has one: that in which A4 would
/// bend it, with the sign of A4.
[[nodiscard]] hal::Vec3 elbow_direction(const ArmGeometry& arm, const hal::JointVector& q_rad);

/// Limits less a margin.
struct JointRange {
  hal::JointVector lower_rad, upper_rad;
  JointRange(const ArmGeometry& arm, double margin_rad)
      : lower_rad(arm.lower_rad.array() + margin_rad), upper_rad(arm.upper_rad.array() - margin_rad) {}
};

/// All solutions in the range with the elbow at psi. `near`: where A1 and A5 stay if they can in singular
/// positions.
int solve_on_circle(const ElbowCircle& circle, double psi_rad, const JointRange& range,
                    const hal::JointVector* near, std::array<IkSolution, 8>& out);

/// Elbow angles at which a joint can meet an end of its range, for A4 positive and negative alike, sorted in
/// (-pi, pi]. Between two neighbours every branch is either in range all the way or nowhere. Returns how
/// many.
inline constexpr std::size_t kMaxElbowEnds = 48;
std::size_t elbow_ends(const ElbowCircle& circle, const JointRange& range,
                       std::array<double, kMaxElbowEnds>& ends);

}  // namespace colift::planner
