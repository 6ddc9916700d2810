#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cmath>
#include <utility>

// Values with Eigen's types go from program to library and back, so both need one layout. A compiler with
// -march=native or -mavx would align them to 32 bytes, and CoLift (with Debian's PCL) is built for 16.
static_assert(EIGEN_MAX_ALIGN_BYTES == 16 && EIGEN_MAX_STATIC_ALIGN_BYTES == 16 &&
                  EIGEN_MALLOC_ALREADY_ALIGNED == 1,
              "CoLift needs EIGEN_MAX_ALIGN_BYTES=16 and EIGEN_MALLOC_ALREADY_ALIGNED=1 in every file that "
              "includes it: link CoLift::hal with CMake, which sets both, or add them to the compiler's "
              "options");

namespace colift::hal {

// Frames are letters: W world (robot base, or the cloud's own frame when no camera pose is known), B arm
// base, F flange, H hand, C camera optical, T target, P partner's palm. X_WC is the pose of C in W, so X_WT =
// X_WC * X_CT can be checked by eye; p_WT is the point T in W.
using Vec3 = Eigen::Vector3d;
using Pose = Eigen::Isometry3d;
using Aabb = Eigen::AlignedBox3d;

/// Force (N) and torque (N m, about the point that the user of the type names).
struct Wrench {
  Vec3 force = Vec3::Zero();
  Vec3 torque = Vec3::Zero();
};

/// The plane normal . p + offset = 0 with a unit normal (m).
struct Plane {
  Vec3 normal = Vec3::UnitZ();
  double offset = 0.0;

  /// Signed distance of a point, positive on the side of the normal (m).
  [[nodiscard]] double height(const Vec3& p) const { return normal.dot(p) + offset; }
  [[nodiscard]] Vec3 foot(const Vec3& p) const { return p - height(p) * normal; }

  /// The same plane in frame A, for a plane given in frame B.
  [[nodiscard]] Plane in(const Pose& X_AB) const {
    const Vec3 n = X_AB.linear() * normal;
    return {n, offset - n.dot(X_AB.translation())};
  }
};

/// A box at any orientation: axes are the columns of a right-handed rotation, size is the full length along
/// each.
struct OrientedBox {
  Vec3 center = Vec3::Zero();
  Eigen::Matrix3d axes = Eigen::Matrix3d::Identity();
  Vec3 size = Vec3::Zero();
};

/// Two unit vectors that complete a unit vector to a right-handed frame (u, v, n). Deterministic.
[[nodiscard]] inline std::pair<Vec3, Vec3> tangents(const Vec3& n) {
  const Vec3 helper = std::abs(n.z()) < 0.9 ? Vec3::UnitZ() : Vec3::UnitX();
  const Vec3 u = helper.cross(n).normalized();
  return {u, n.cross(u)};
}

}  // namespace colift::hal
