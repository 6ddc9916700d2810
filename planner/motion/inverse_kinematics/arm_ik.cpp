#include "planner/motion/inverse_kinematics/arm_ik.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "planner/motion/inverse_kinematics/arm_ik_circle.hpp"

namespace colift::planner {
namespace {

using hal::JointVector;
using hal::Pose;
using hal::Vec3;

constexpr double kPi = std::numbers::pi;

double angle_on_circle(const Vec3& n, const Vec3& direction) {
  const Vec3 u = up_across(n);
  return std::atan2(direction.dot(n.cross(u)), direction.dot(u));
}

Vec3 shoulder_to_wrist(const ArmGeometry& arm, const Pose& X_WF) {
  return (X_WF.translation() - arm.wrist_to_flange_m * X_WF.linear().col(2) -
          Vec3(0.0, 0.0, arm.base_to_shoulder_m))
      .normalized();
}

double score_of(const JointVector& q_rad, const JointVector& middle, const JointVector& half) {
  const double farthest = ((q_rad - middle).array() / half.array()).square().maxCoeff();
  return std::max(0.0, 1.0 - farthest) * std::sqrt(std::abs(std::sin(q_rad[3]) * std::sin(q_rad[5])));
}

}  // namespace

hal::Result<ArmGeometry> arm_geometry(const hal::RobotModel& model) {
  const auto refuse = [&](std::string text) {
    return hal::failure(hal::ErrorCode::BadConfig, model.name, std::move(text));
  };
  constexpr double kSame = 1e-6;  // rounding of a model file (m, and components of unit vectors)
  const Vec3 y = Vec3::UnitY(), z = Vec3::UnitZ();
  const std::array<Vec3, hal::kArmJoints> axes{z, -y, z, y, z, -y, z};
  std::vector<Pose> X_WL;
  hal::link_poses(model, JointVector::Zero(), {}, X_WL);
  std::array<double, hal::kArmJoints + 1> height{};
  for (std::size_t i = 0; i <= hal::kArmJoints; ++i) {
    const auto link = static_cast<std::size_t>(i < hal::kArmJoints ? model.arm[i] : model.flange);
    const Pose& X = X_WL[link];
    height[i] = X.translation().z();
    if (std::hypot(X.translation().x(), X.translation().y()) > kSame || !X.linear().isIdentity(kSame)) {
      return refuse(fmt::format("link {} does not stand upright on the line of A1 with all joints at 0",
                                model.links[link].name));
    }
    if (i < hal::kArmJoints && !(model.links[link].axis - axes[i]).isMuchSmallerThan(1.0, kSame)) {
      return refuse(fmt::format("the axis of joint {} is none of an arm with axes z, -y, z, y, z, -y, z",
                                model.links[link].joint));
    }
  }
  ArmGeometry arm{height[1],         height[3] - height[1], height[5] - height[3], height[7] - height[5],
                  model.lower_rad(), model.upper_rad()};
  if (!(arm.upper_arm_m > 0.0 && arm.forearm_m > 0.0))
    return refuse("the arm's joints do not stand in order");
  for (const int i : {1, 3, 5}) {
    if (arm.lower_rad[i] < -kPi || arm.upper_rad[i] > kPi)
      return refuse("a joint turns by more than half a turn");
  }
  return arm;
}

Pose flange_pose(const ArmGeometry& arm, const JointVector& q_rad) {
  Pose X = Pose::Identity();
  const auto about_z = [&](double q) {
    X.linear() *= Eigen::AngleAxisd(q, Vec3::UnitZ()).toRotationMatrix();
  };
  const auto about_y = [&](double q) {
    X.linear() *= Eigen::AngleAxisd(q, Vec3::UnitY()).toRotationMatrix();
  };
  about_z(q_rad[0]);
  about_y(-q_rad[1]);
  about_z(q_rad[2]);
  X.translation() = Vec3(0.0, 0.0, arm.base_to_shoulder_m) + arm.upper_arm_m * X.linear().col(2);
  about_y(q_rad[3]);
  about_z(q_rad[4]);
  X.translation() += arm.forearm_m * X.linear().col(2);
  about_y(-q_rad[5]);
  about_z(q_rad[6]);
  X.translation() += arm.wrist_to_flange_m * X.linear().col(2);
  return X;
}

double elbow_angle(const ArmGeometry& arm, const JointVector& q_rad) {
  return angle_on_circle(shoulder_to_wrist(arm, flange_pose(arm, q_rad)), elbow_direction(arm, q_rad));
}

int solve_ik(const ArmGeometry& arm, const Pose& X_WF, double elbow_rad, double margin_rad,
             std::array<IkSolution, 8>& out) {
  const auto circle = elbow_circle(arm, X_WF);
  if (!circle || !std::isfinite(elbow_rad)) return 0;
  return solve_on_circle(*circle, elbow_rad, JointRange(arm, margin_rad), nullptr, out);
}

std::vector<ScoredIk> all_ik(const ArmGeometry& arm, const Pose& X_WF, double margin_rad, int steps) {
  std::vector<ScoredIk> all;
  const auto circle = elbow_circle(arm, X_WF);
  if (!circle) return all;
  const JointRange range(arm, margin_rad);
  const JointVector middle = 0.5 * (arm.lower_rad + arm.upper_rad);
  const JointVector half = 0.5 * (arm.upper_rad - arm.lower_rad);
  std::array<IkSolution, 8> found;
  const auto add = [&](double psi_rad) {
    const int count = solve_on_circle(*circle, psi_rad, range, nullptr, found);
    for (int i = 0; i < count; ++i) {
      const IkSolution& ik = found[static_cast<std::size_t>(i)];
      all.push_back({ik, score_of(ik.q_rad, middle, half)});
    }
  };
  all.reserve(64);
  for (int i = 1; i <= steps; ++i) add(-kPi + 2.0 * kPi * i / steps);
  if (all.empty()) {
    std::array<double, kMaxElbowEnds> ends;
    const std::size_t count = elbow_ends(*circle, range, ends);
    for (std::size_t i = 0; i < count; ++i) {
      const double next = i + 1 < count ? ends[i + 1] : ends[0] + 2.0 * kPi;
      add(0.5 * (ends[i] + next));
    }
    // an interval of no width: the pose is reached with two joints at their limits
    for (std::size_t i = 0; i < count && all.empty(); ++i) add(ends[i]);
  }
  std::sort(all.begin(), all.end(), [](const ScoredIk& a, const ScoredIk& b) {
    return a.score != b.score ? a.score > b.score
                              : std::pair(a.elbow_rad, a.branch) < std::pair(b.elbow_rad, b.branch);
  });
  return all;
}

std::optional<JointVector> follow_ik(const ArmGeometry& arm, const Pose& X_WF, const JointVector& near_rad,
                                     double margin_rad, double max_step_rad) {
  const auto circle = elbow_circle(arm, X_WF);
  if (!circle || !near_rad.allFinite()) return std::nullopt;
  const JointRange range(arm, margin_rad);
  // near the vertical the angle against "up" turns fast: there the elbow keeps its direction instead
  constexpr double kNearVertical = 0.05;  // sine: 3 degrees
  const Vec3 n_near = shoulder_to_wrist(arm, flange_pose(arm, near_rad));
  const bool vertical = std::min(n_near.head<2>().norm(), circle->n.head<2>().norm()) < kNearVertical;
  const double kept = angle_on_circle(vertical ? circle->n : n_near, elbow_direction(arm, near_rad));

  std::array<IkSolution, 8> found;
  const auto nearest = [&](double psi_rad) -> std::optional<JointVector> {
    const int count = solve_on_circle(*circle, psi_rad, range, &near_rad, found);
    const IkSolution* best = nullptr;
    double least = max_step_rad;
    for (int i = 0; i < count; ++i) {
      const IkSolution& ik = found[static_cast<std::size_t>(i)];
      const double step = (ik.q_rad - near_rad).cwiseAbs().maxCoeff();
      if (step <= least) best = &ik, least = step;
    }
    return best ? std::optional(best->q_rad) : std::nullopt;
  };
  if (auto q = nearest(kept)) return q;
  // elbow angles up to max_step_rad to either side, and halvings towards the one that was kept
  constexpr int kTries = 8, kHalvings = 8;
  for (int i = 1; i <= kTries; ++i) {
    for (const double side : {1.0, -1.0}) {
      double out = side * max_step_rad * i / kTries, in = side * max_step_rad * (i - 1) / kTries;
      auto q = nearest(kept + out);
      if (!q) continue;
      for (int k = 0; k < kHalvings; ++k) {
        const double middle = 0.5 * (in + out);
        if (auto better = nearest(kept + middle)) {
          q = better, out = middle;
        } else {
          in = middle;
        }
      }
      return q;
    }
  }
  return std::nullopt;
}

}  // namespace colift::planner
