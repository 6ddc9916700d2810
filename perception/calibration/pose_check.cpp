#include "perception/calibration/pose_check.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "hal/types/symmetric.hpp"
#include "hal/types/units.hpp"
#include "perception/calibration/arm_in_view/arm_surface.hpp"

namespace colift::perception {
namespace {

/// Points that may be the arm's: within reach of its model, above the floor.
std::vector<Vec3> points_near(const hal::DepthFrame& frame, const Pose& X_BC, const ArmSurface& surface,
                              const PoseCheckConfig& config) {
  std::vector<Vec3> out;
  const auto& k = frame.intrinsics;
  if (frame.depth_m.size() != static_cast<std::size_t>(k.width) * static_cast<std::size_t>(k.height))
    return out;
  const hal::Aabb around = surface.around(0.35);
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
      if (std::abs(surface.nearest(p).distance_m) < config.reach_m) out.push_back(p);
    }
  return out;
}

/// The shift of the points that brings them onto the model.
Vec3 fit_shift(const std::vector<Vec3>& points, const ArmSurface& surface, const PoseCheckConfig& config) {
  const double reach_m = config.reach_m, robust_m = config.robust_m;
  Vec3 shift = Vec3::Zero();
  for (int round = 0; round < config.iterations; ++round) {
    Eigen::Matrix3d H = Eigen::Matrix3d::Zero();
    Vec3 g = Vec3::Zero();
    double weights = 0.0;
    for (const Vec3& p : points) {
      const auto [d, n, body] = surface.nearest(p + shift);
      if (std::abs(d) > reach_m) continue;
      const double w = std::abs(d) > robust_m ? robust_m / std::abs(d) : 1.0;
      H += w * n * n.transpose();
      g += w * d * n;
      weights += w;
    }
    if (!(weights > 0.0)) break;
    // only along directions that enough of the surface faces
    const hal::SmallSymmetricEigen eigen = hal::small_symmetric_eigen(H / weights);
    Vec3 step = Vec3::Zero();
    for (int a = 0; a < 3; ++a) {
      if (eigen.values[a] < config.min_direction_fraction) continue;
      const Vec3 axis = eigen.vectors.col(a);
      step -= axis * (axis.dot(g) / weights / eigen.values[a]);
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
  const ArmSurface surface(robot, q_rad, hand);
  const std::vector<Vec3> points = points_near(frame, X_BC, surface, config);
  const bool arm_seen =
      points.size() * static_cast<std::size_t>(config.stride) * static_cast<std::size_t>(config.stride) >=
      static_cast<std::size_t>(config.min_points);
  if (arm_seen) {
    out.arm_points = static_cast<int>(points.size());
    out.arm_off_B = -fit_shift(points, surface, config);
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
