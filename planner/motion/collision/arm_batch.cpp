#include "planner/motion/collision/arm_batch.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace colift::planner {
namespace {

using hal::Pose;
using hal::Vec3;

/// Spheres are larger by this: rounding of the kinematics in single precision (m).
constexpr float kRounding = 2e-5f;

/// Rotation that takes z to the axis, without Eigen's SVD in FromTwoVectors.
Pose turned_to(const Vec3& axis) {
  const auto [u, v] = hal::tangents(axis);
  Pose X = Pose::Identity();
  X.linear() << u, v, axis;
  return X;
}

}  // namespace

ArmBodies::ArmBodies(const hal::RobotModel& model, const SphereModel& spheres) : spheres_(spheres) {
  const std::vector<int> body = arm_body(model);
  for (const LinkSphere& s : spheres_.spheres) {
    if (groups.empty() || groups.back().link != s.link) {
      SphereGroup group;
      group.link = s.link;
      group.body = body[static_cast<std::size_t>(s.link)];
      group.in_hand = model.in_hand(s.link);
      group.first = static_cast<int>(radius_m.size());
      groups.push_back(group);
    }
    ++groups.back().count;
    radius_m.push_back(static_cast<float>(s.radius_m) + kRounding);
  }
  x.resize(radius_m.size());
  y.resize(radius_m.size());
  z.resize(radius_m.size());
  set_hand(model, {});
}

void ArmBodies::set_hand(const hal::RobotModel& model, const hal::HandPosture& hand) {
  std::vector<Pose> X_WL;
  hal::link_poses(model, hal::JointVector::Zero(), hand, X_WL);
  std::array<Pose, hal::kArmJoints + 1> X_WB;
  X_WB[0] = Pose::Identity();
  for (std::size_t k = 1; k < X_WB.size(); ++k) {
    const auto link = static_cast<std::size_t>(model.arm[k - 1]);
    X_WB[k] = X_WL[link] * turned_to(model.links[link].axis);
  }
  for (std::size_t k = 0; k < X_WB.size(); ++k) {
    X_PB0[k] = (k == 0 ? Pose::Identity() : X_WB[k - 1].inverse() * X_WB[k]).cast<float>();
  }
  X_7H = (X_WB.back().inverse() * X_WL[static_cast<std::size_t>(model.palm)]).cast<float>();

  for (SphereGroup& group : groups) {
    const Pose X_BL =
        X_WB[static_cast<std::size_t>(group.body)].inverse() * X_WL[static_cast<std::size_t>(group.link)];
    hal::Aabb box;
    for (int i = group.first; i < group.first + group.count; ++i) {
      const auto s = static_cast<std::size_t>(i);
      const Vec3 p = X_BL * spheres_.spheres[s].center_L;
      box.extend(p);
      x[s] = static_cast<float>(p.x());
      y[s] = static_cast<float>(p.y());
      z[s] = static_cast<float>(p.z());
    }
    group.middle = box.center().cast<float>();
    group.radius_m = 0.0f;
    for (int i = group.first; i < group.first + group.count; ++i) {
      const auto s = static_cast<std::size_t>(i);
      const float away = (Eigen::Vector3f(x[s], y[s], z[s]) - group.middle).norm();
      group.radius_m = std::max(group.radius_m, away + radius_m[s] + kRounding);
    }
  }
}

template <std::size_t N>
void ArmBatch<N>::turn(const ArmBodies& bodies, const std::array<hal::JointVector, N>& q_rad) {
  constexpr double kTurn = 2.0 * std::numbers::pi;
  Frame& base = X_WB[0];
  for (std::size_t i = 0; i < 9; ++i) base.r[i].fill(i % 4 == 0 ? 1.0f : 0.0f);
  for (Lanes& t : base.t) t.fill(0.0f);

  for (std::size_t k = 1; k < X_WB.size(); ++k) {
    Lanes sine, cosine;
    for (std::size_t l = 0; l < N; ++l) {
      const double q = q_rad[l][static_cast<Eigen::Index>(k - 1)];
      sine[l] = static_cast<float>(0.5 * (q - kTurn * std::nearbyint(q / kTurn)));
    }
    // Taylor series of the half angle, which is at most a quarter turn: below 1e-7 off
    for (std::size_t l = 0; l < N; ++l) {
      const float h = sine[l], h2 = h * h;
      const float s =
          h * (1.0f +
               h2 * (-1.0f / 6 + h2 * (1.0f / 120 + h2 * (-1.0f / 5040 +
                                                          h2 * (1.0f / 362880 + h2 * (-1.0f / 39916800))))));
      const float c =
          1.0f +
          h2 * (-1.0f / 2 +
                h2 * (1.0f / 24 + h2 * (-1.0f / 720 + h2 * (1.0f / 40320 + h2 * (-1.0f / 3628800 +
                                                                                 h2 * (1.0f / 479001600))))));
      sine[l] = 2.0f * s * c;
      cosine[l] = 1.0f - 2.0f * s * s;
    }
    const Frame& parent = X_WB[k - 1];
    Frame& own = X_WB[k];
    const Eigen::Matrix3f R = bodies.X_PB0[k].linear();
    const Eigen::Vector3f t = bodies.X_PB0[k].translation();
    for (std::size_t row = 0; row < 3; ++row) {
      const Lanes &a = parent.r[row], &b = parent.r[3 + row], &c = parent.r[6 + row];
      for (std::size_t l = 0; l < N; ++l) {
        const float x0 = a[l] * R(0, 0) + b[l] * R(1, 0) + c[l] * R(2, 0);
        const float y0 = a[l] * R(0, 1) + b[l] * R(1, 1) + c[l] * R(2, 1);
        own.r[6 + row][l] = a[l] * R(0, 2) + b[l] * R(1, 2) + c[l] * R(2, 2);
        own.t[row][l] = a[l] * t[0] + b[l] * t[1] + c[l] * t[2] + parent.t[row][l];
        own.r[row][l] = cosine[l] * x0 + sine[l] * y0;
        own.r[3 + row][l] = cosine[l] * y0 - sine[l] * x0;
      }
    }
  }
}

template struct ArmBatch<4>;
template struct ArmBatch<16>;

}  // namespace colift::planner
