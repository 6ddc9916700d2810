#include "perception/ground.hpp"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <vector>

#include "perception/plane_vote.hpp"

namespace colift::perception {
namespace {

constexpr double kRad = std::numbers::pi / 180.0;
constexpr double kParallelDeg = 8.0;
constexpr double kSameLevel_m = 0.02;
// weighted least squares on the pixels; the tolerance shrinks so that the rims of low objects fall out
Ground refine(Plane plane, const OrganisedCloud& cloud, const NoiseModel& noise, const GroundConfig& c) {
  const Vec3 eye = cloud.X_WC.translation();
  Ground ground{plane, 0, 0.0};
  for (int round = 0; round < 4; ++round) {
    // the plane as a height over itself: h = a + b s + c t with tangents s, t around the eye's foot
    const auto [s_axis, t_axis] = hal::tangents(plane.normal);
    const Vec3 origin = plane.foot(eye);
    const Eigen::Vector3f n = plane.normal.cast<float>(), s = s_axis.cast<float>(), t = t_axis.cast<float>();
    const Eigen::Vector3f o = origin.cast<float>();
    const float eye_height = std::max(1e-3f, static_cast<float>(plane.height(eye)));
    const bool last = round == 3;
    const float width = std::array{2.0f, 1.5f, 1.0f, 1.0f}[static_cast<std::size_t>(round)];
    const float factor = width * static_cast<float>(c.tolerance_sigma);
    const float base = width * static_cast<float>(c.tolerance_m);
    const float sigma0 = static_cast<float>(noise.sigma0_m), sigma2 = static_cast<float>(noise.sigma2_per_m);

    double sums[9] = {};  // w, ws, wt, wss, wst, wtt, wh, wsh, wth
    double square = 0.0;
    std::size_t count = 0;
    const std::size_t stride = last ? 1 : 3;
    for (std::size_t i = 0; i < cloud.size(); i += stride) {
      if (!cloud.seen(i)) continue;
      const float dx = cloud.x[i] - o.x(), dy = cloud.y[i] - o.y(), dz = cloud.z[i] - o.z();
      const float h = n.x() * dx + n.y() * dy + n.z() * dz;
      const float d = cloud.depth_m[i];
      // depth noise enters the height by the slope of the ray: eye height over depth
      const float sigma = (sigma0 + sigma2 * d * d) * std::min(1.0f, eye_height / d);
      if (std::abs(h) > base + factor * sigma) continue;
      ++count;
      square += static_cast<double>(h) * h;
      const float ss = s.x() * dx + s.y() * dy + s.z() * dz;
      const float tt = t.x() * dx + t.y() * dy + t.z() * dz;
      const float w = 1e-6f / (sigma * sigma + 1e-7f);
      sums[0] += w;
      sums[1] += w * ss;
      sums[2] += w * tt;
      sums[3] += w * ss * ss;
      sums[4] += w * ss * tt;
      sums[5] += w * tt * tt;
      sums[6] += w * h;
      sums[7] += w * ss * h;
      sums[8] += w * tt * h;
    }
    if (count < 50) break;
    ground = {plane, count, std::sqrt(square / static_cast<double>(count))};
    if (last) break;
    Eigen::Matrix3d A;
    A << sums[0], sums[1], sums[2], sums[1], sums[3], sums[4], sums[2], sums[4], sums[5];
    const Vec3 x = A.ldlt().solve(Vec3(sums[6], sums[7], sums[8]));
    if (!x.allFinite()) break;
    const Vec3 normal = (plane.normal - x[1] * s_axis - x[2] * t_axis).normalized();
    const Vec3 point = origin + x[0] * plane.normal;
    plane = {normal, -normal.dot(point)};
  }
  return ground;
}

}  // namespace

GroundResult find_ground(const OrganisedCloud& cloud, const std::vector<BlockPlane>& blocks,
                         const std::optional<Vec3>& up_W, const NoiseModel& noise, const GroundConfig& c) {
  const std::size_t seen = static_cast<std::size_t>(
      std::count_if(cloud.depth_m.begin(), cloud.depth_m.end(), [](float d) { return d == d; }));
  const Vec3 up = up_W.value_or(-cloud.X_WC.linear().col(1));
  const double max_tilt_deg = up_W ? c.max_tilt_deg : c.max_tilt_unknown_deg;
  const auto faces_up = [&](const Vec3& n) { return n.dot(up) > std::cos(max_tilt_deg * kRad); };

  const std::vector<VotedPlane> level = vote_planes(blocks, faces_up, noise, {c.tolerance_m, c.tolerance_sigma});
  if (level.empty()) {
    return {std::nullopt, fmt::format("no ground: none of {} flat image blocks lie on a plane that faces up within "
                                      "{:.0f} degrees", blocks.size(), max_tilt_deg)};
  }

  // the lowest of the planes that are parallel to the largest one and large enough
  const Vec3 eye = cloud.X_WC.translation();
  const VotedPlane* best = &level.front();
  for (const VotedPlane& l : level) {
    if (l.area_m2 < c.min_area_ratio * level.front().area_m2) continue;
    if (l.plane.normal.dot(level.front().plane.normal) < std::cos(kParallelDeg * kRad)) continue;
    if (l.plane.height(eye) > best->plane.height(eye) + kSameLevel_m) best = &l;
  }

  const Ground ground = refine(best->plane, cloud, noise, c);
  if (static_cast<double>(ground.inliers) < c.min_image_fraction * static_cast<double>(seen)) {
    return {std::nullopt, fmt::format("no ground: the best level plane explains {} of {} seen pixels, {:.0f} % are "
                                      "needed", ground.inliers, seen, 100 * c.min_image_fraction)};
  }
  return {ground, fmt::format("ground: {} pixels within {:.1f} mm rms, camera {:.2f} m above it", ground.inliers,
                              1000 * ground.rms_m, ground.plane.height(eye))};
}

}  // namespace colift::perception
