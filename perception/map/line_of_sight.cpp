#include "perception/map/line_of_sight.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

namespace colift::perception {
namespace {

constexpr double kPast_m = 0.08;    // three sigma of a Kinect at 4 m
constexpr double kBefore_m = 0.05;  // and of what hides a point at 3 m

/// NaN where nothing was measured; unset outside of the image.
std::optional<double> depth_at(const OrganisedCloud& cloud, double u, double v) {
  if (!cloud.contains(u, v)) return std::nullopt;
  const auto row = static_cast<std::size_t>(std::lround(v)),
             column = static_cast<std::size_t>(std::lround(u));
  return static_cast<double>(cloud.depth_m[row * static_cast<std::size_t>(cloud.width()) + column]);
}

}  // namespace

bool looks_past(const OrganisedCloud& cloud, const hal::Pose& X_CW, const hal::Vec3& p_W, double half_m) {
  const hal::Vec3 p = X_CW * p_W;
  if (!(p.z() > kPast_m)) return false;
  const hal::CameraIntrinsics& k = cloud.intrinsics;
  const double u = k.fx * p.x() / p.z() + k.cx, v = k.fy * p.y() / p.z() + k.cy;
  const double du = std::max(1.0, k.fx * half_m / p.z()), dv = std::max(1.0, k.fy * half_m / p.z());
  const auto beyond = [&](double at_u, double at_v) {
    const auto measured = depth_at(cloud, at_u, at_v);
    return measured && *measured > p.z() + kPast_m;
  };
  return beyond(u, v) && beyond(u - du, v) && beyond(u + du, v) && beyond(u, v - dv) && beyond(u, v + dv);
}

bool is_hidden(const OrganisedCloud& cloud, const hal::Pose& X_CW, const hal::Vec3& p_W) {
  const hal::Vec3 p = X_CW * p_W;
  if (!(p.z() > kBefore_m)) return true;
  const hal::CameraIntrinsics& k = cloud.intrinsics;
  const auto measured = depth_at(cloud, k.fx * p.x() / p.z() + k.cx, k.fy * p.y() / p.z() + k.cy);
  return !measured || !(*measured >= p.z() - kBefore_m);
}

}  // namespace colift::perception
