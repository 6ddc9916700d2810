#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "hal/robot_model/robot_model.hpp"
#include "planner/motion/collision/collision_spheres.hpp"

namespace colift::planner {

/// Spheres of one link, with one around them all. Numbers in the frame of the body that carries them.
struct SphereGroup {
  int link = 0, body = 0;
  bool in_hand = false;
  int first = 0, count = 0;  ///< Its spheres.
  Eigen::Vector3f middle = Eigen::Vector3f::Zero();
  float radius_m = 0.0f;
};

/// The arm as eight rigid bodies (0 stands, k is carried by joint Ak; the hand belongs to 7) with their
/// spheres. Each body's frame has the joint's axis as z, so that a joint position only mixes two columns.
class ArmBodies {
 public:
  ArmBodies(const hal::RobotModel& model, const SphereModel& spheres);
  /// Places the hand's spheres for a posture of its joints.
  void set_hand(const hal::RobotModel& model, const hal::HandPosture& hand);

  std::vector<SphereGroup> groups;  ///< Links ascending.
  std::vector<float> x, y, z, radius_m;
  /// Pose of body k in body k - 1 at joint position 0, k = 1 to 7; entry 0 is the identity.
  std::array<Eigen::Isometry3f, hal::kArmJoints + 1> X_PB0;
  Eigen::Isometry3f X_7H = Eigen::Isometry3f::Identity();  ///< Palm in body 7.

 private:
  SphereModel spheres_;
};

/// Forward kinematics and sphere positions of N joint positions at a time, in single precision, laid out so
/// that the compiler uses one lane per joint position.
template <std::size_t N>
struct ArmBatch {
  using Lanes = std::array<float, N>;
  struct Frame {
    std::array<Lanes, 9> r;  ///< Rotation, by columns.
    std::array<Lanes, 3> t;
  };
  std::array<Frame, hal::kArmJoints + 1> X_WB;
  struct Point {
    Lanes x, y, z;
  };
  std::vector<Point> group;          ///< Middle of each group in W.
  std::vector<Point> sphere;         ///< Of the groups for which place() was called.
  std::vector<std::uint8_t> placed;  ///< By group.
  std::size_t used = N;              ///< Lanes that hold joint positions; the others repeat the first one.

  void set_joints(const ArmBodies& bodies, const std::array<hal::JointVector, N>& q_rad, std::size_t count) {
    used = count;
    turn(bodies, q_rad);
    group.resize(bodies.groups.size());
    sphere.resize(bodies.x.size());
    placed.assign(bodies.groups.size(), 0);
    for (std::size_t g = 0; g < group.size(); ++g) {
      const SphereGroup& of = bodies.groups[g];
      at(X_WB[static_cast<std::size_t>(of.body)], of.middle.x(), of.middle.y(), of.middle.z(), group[g]);
    }
  }

  void place(const ArmBodies& bodies, std::size_t g) {
    if (placed[g] != 0) return;
    placed[g] = 1;
    const SphereGroup& of = bodies.groups[g];
    for (int s = of.first; s < of.first + of.count; ++s) {
      const auto i = static_cast<std::size_t>(s);
      at(X_WB[static_cast<std::size_t>(of.body)], bodies.x[i], bodies.y[i], bodies.z[i], sphere[i]);
    }
  }

  [[nodiscard]] Eigen::Isometry3f body_pose(int body, std::size_t lane) const {
    const Frame& f = X_WB[static_cast<std::size_t>(body)];
    Eigen::Isometry3f X = Eigen::Isometry3f::Identity();
    for (int c = 0; c < 3; ++c) {
      for (int row = 0; row < 3; ++row) X.linear()(row, c) = f.r[static_cast<std::size_t>(3 * c + row)][lane];
    }
    X.translation() = Eigen::Vector3f(f.t[0][lane], f.t[1][lane], f.t[2][lane]);
    return X;
  }

 private:
  static void at(const Frame& f, float x, float y, float z, Point& out) {
    for (std::size_t l = 0; l < N; ++l) {
      out.x[l] = f.r[0][l] * x + f.r[3][l] * y + f.r[6][l] * z + f.t[0][l];
      out.y[l] = f.r[1][l] * x + f.r[4][l] * y + f.r[7][l] * z + f.t[1][l];
      out.z[l] = f.r[2][l] * x + f.r[5][l] * y + f.r[8][l] * z + f.t[2][l];
    }
  }
  void turn(const ArmBodies& bodies, const std::array<hal::JointVector, N>& q_rad);
};

extern template struct ArmBatch<4>;
extern template struct ArmBatch<16>;

}  // namespace colift::planner
