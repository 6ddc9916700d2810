#include "perception/calibration/pose_check.hpp"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <vector>

#include "hal/types/units.hpp"

namespace colift::perception {
namespace {

/// A link's solid with its place.
struct Solid {
  hal::LinkShape::Kind kind;
  Pose X_SB;
  Vec3 half;  // box: half lengths; cylinder: radius, half length; sphere: radius
};

/// Signed distance to a solid, and its direction.
double distance_to(const Solid& s, const Vec3& p_B, Vec3& normal_B) {
  const Vec3 p = s.X_SB * p_B;
  Vec3 n = Vec3::UnitZ();
  double d = 0.0;
  switch (s.kind) {
    case hal::LinkShape::Kind::Sphere: {
      const double r = p.norm();
      d = r - s.half.x();
      if (r > 1e-9) n = p / r;
      break;
    }
    case hal::LinkShape::Kind::Cylinder: {
      const double r = std::hypot(p.x(), p.y());
      const double a = r - s.half.x(), b = std::abs(p.z()) - s.half.y();
      const Vec3 radial = r > 1e-9 ? Vec3(p.x() / r, p.y() / r, 0.0) : Vec3(Vec3::UnitX());
      const Vec3 axial(0.0, 0.0, p.z() < 0 ? -1.0 : 1.0);
      if (a > 0 && b > 0) {
        d = std::hypot(a, b);
        n = (a * radial + b * axial) / d;
      } else {
        d = std::max(a, b);
        n = a > b ? radial : axial;
      }
      break;
    }
    case hal::LinkShape::Kind::Box: {
      const Vec3 q = p.cwiseAbs() - s.half;
      const Vec3 sign(p.x() < 0 ? -1.0 : 1.0, p.y() < 0 ? -1.0 : 1.0, p.z() < 0 ? -1.0 : 1.0);
      const Vec3 out = q.cwiseMax(0.0);
      if (out.norm() > 1e-9) {
        d = out.norm();
        n = out.cwiseProduct(sign) / d;
      } else {
        int axis = 0;
        d = q.maxCoeff(&axis);
        n = Vec3::Unit(axis) * sign[axis];
      }
      break;
    }
  }
  normal_B = s.X_SB.linear().transpose() * n;
  return d;
}

double distance_to(const std::vector<Solid>& solids, const Vec3& p_B, Vec3& normal_B) {
  double best = 1e9;
  Vec3 n;
  for (const Solid& s : solids) {
    const double d = distance_to(s, p_B, n);
    if (d < best) best = d, normal_B = n;
  }
  return best;
}

std::vector<Solid> solids_of(const hal::RobotModel& robot, const hal::JointVector& q_rad,
                             const hal::HandPosture& hand) {
  std::vector<Pose> X_BL;
  hal::link_poses(robot, q_rad, hand, X_BL);
  std::vector<Solid> out;
  for (std::size_t i = 0; i < robot.links.size(); ++i)
    for (const hal::LinkShape& s : robot.links[i].shapes) {
      Vec3 half = 0.5 * s.size;
      if (s.kind == hal::LinkShape::Kind::Sphere) half.x() = s.size.x();
      if (s.kind == hal::LinkShape::Kind::Cylinder) half = {s.size.x(), 0.5 * s.size.y(), 0.0};
      out.push_back({s.kind, (X_BL[i] * s.X_LS).inverse(), half});
    }
  return out;
}

/// Points that may be the arm's: within reach of its model, above the floor.
std::vector<Vec3> points_near(const hal::DepthFrame& frame, const Pose& X_BC,
                              const std::vector<Solid>& solids, const hal::Aabb& around,
                              const PoseCheckConfig& config) {
  std::vector<Vec3> out;
  const auto& k = frame.intrinsics;
  if (frame.depth_m.size() != static_cast<std::size_t>(k.width) * static_cast<std::size_t>(k.height))
    return out;
  Vec3 normal;
  for (int v = 1; v < k.height - 1; v += config.stride)
    for (int u = 1; u < k.width - 1; u += config.stride) {
      const auto at = [&](int x, int y) {
        return static_cast<double>(frame.depth_m[static_cast<std::size_t>(y * k.width + x)]);
      };
      const double z = at(u, v);
      if (!(z > 0.0)) continue;
      const Vec3 p = X_BC * Vec3((u - k.cx) / k.fx * z, (v - k.cy) / k.fy * z, z);
      if (p.z() < config.min_arm_height_m || !around.contains(p)) continue;
      // at a silhouette the depth is neither the arm's nor the background's
      const double jump =
          std::max(std::abs(at(u - 1, v) - at(u + 1, v)), std::abs(at(u, v - 1) - at(u, v + 1)));
      if (!(jump < config.max_depth_step_m)) continue;
      if (std::abs(distance_to(solids, p, normal)) < config.reach_m) out.push_back(p);
    }
  return out;
}

/// The shift of the points that brings them onto the model.
Vec3 fit_shift(const std::vector<Vec3>& points, const std::vector<Solid>& solids,
               const PoseCheckConfig& config) {
  const double reach_m = config.reach_m, robust_m = config.robust_m;
  Vec3 shift = Vec3::Zero();
  for (int round = 0; round < config.iterations; ++round) {
    Eigen::Matrix3d H = Eigen::Matrix3d::Zero();
    Vec3 g = Vec3::Zero();
    Vec3 n;
    double weights = 0.0;
    for (const Vec3& p : points) {
      const double d = distance_to(solids, p + shift, n);
      if (std::abs(d) > reach_m) continue;
      const double w = std::abs(d) > robust_m ? robust_m / std::abs(d) : 1.0;
      H += w * n * n.transpose();
      g += w * d * n;
      weights += w;
    }
    if (!(weights > 0.0)) break;
    // only along directions that enough of the surface faces
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(H / weights);
    Vec3 step = Vec3::Zero();
    for (int a = 0; a < 3; ++a) {
      if (eigen.eigenvalues()[a] < config.min_direction_fraction) continue;
      const Vec3 axis = eigen.eigenvectors().col(a);
      step -= axis * (axis.dot(g) / weights / eigen.eigenvalues()[a]);
    }
    shift += step;
    if (step.norm() < 1e-5 || shift.norm() > 2.0 * reach_m) break;
  }
  return shift;
}

}  // namespace

PoseCheck check_pose(const hal::DepthFrame& frame, const Pose& X_BC,
                     const std::optional<hal::Plane>& ground_B, const hal::RobotModel& robot,
                     const hal::JointVector& q_rad, const hal::HandPosture& hand,
                     const PoseCheckConfig& config) {
  PoseCheck out;
  if (ground_B) {
    out.tilt_rad = std::acos(std::clamp(ground_B->normal.z(), -1.0, 1.0));
    // where the arm works, not at the plane's foot under the base
    const Vec3 before_base(0.7, 0.0, 0.0);
    out.height_m = -ground_B->height(before_base) / std::max(0.1, ground_B->normal.z());
  }
  const std::vector<Solid> solids = solids_of(robot, q_rad, hand);
  hal::Aabb around;
  for (const Solid& s : solids) around.extend(s.X_SB.inverse().translation());
  around.min() -= Vec3::Constant(0.35);
  around.max() += Vec3::Constant(0.35);
  const std::vector<Vec3> points = points_near(frame, X_BC, solids, around, config);
  const bool arm_seen =
      points.size() * static_cast<std::size_t>(config.stride) * static_cast<std::size_t>(config.stride) >=
      static_cast<std::size_t>(config.min_points);
  if (arm_seen) {
    out.arm_points = static_cast<int>(points.size());
    out.arm_off_B = -fit_shift(points, solids, config);
  }
  const double off = out.arm_off_B.norm();
  if (ground_B && hal::rad_to_deg(out.tilt_rad) > config.max_tilt_deg) {
    out.good = false;
    out.reason = fmt::format(
        "the camera is not where its calibration says: the ground is seen tilted by {:.1f} deg "
        "(at most {:.1f}); calibrate again",
        hal::rad_to_deg(out.tilt_rad), config.max_tilt_deg);
  } else if (ground_B && out.height_m < -config.max_height_m) {
    out.good = false;
    out.reason = fmt::format(
        "the camera is not where its calibration says: the ground is seen {:.0f} mm below the "
        "robot's floor (at most {:.0f}); calibrate again",
        -1e3 * out.height_m, 1e3 * config.max_height_m);
  } else if (arm_seen && off > config.max_arm_m) {
    out.good = false;
    out.reason = fmt::format(
        "the camera is not where its calibration says: the arm is seen {:.0f} mm beside its "
        "model, at ({:.0f}, {:.0f}, {:.0f}) mm in the base (at most {:.0f}); calibrate again",
        1e3 * off, 1e3 * out.arm_off_B.x(), 1e3 * out.arm_off_B.y(), 1e3 * out.arm_off_B.z(),
        1e3 * config.max_arm_m);
  } else {
    out.reason = fmt::format(
        "ground {}, {}",
        ground_B ? fmt::format("{:.1f} deg from level", hal::rad_to_deg(out.tilt_rad))
                 : std::string("not seen"),
        arm_seen ? fmt::format("arm {:.0f} mm from its model", 1e3 * off) : std::string("arm not in view"));
  }
  return out;
}

}  // namespace colift::perception
