#include "perception/ground.hpp"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "perception/plane_vote.hpp"

namespace colift::perception {
namespace {

constexpr double kRad = std::numbers::pi / 180.0;
constexpr double kParallelDeg = 8.0;
constexpr double kSameLevel_m = 0.02;
constexpr float kWidest = 2.0f;              // first tolerance of the pixel fit, relative to the last
constexpr int kFitStride = 2;                // every second pixel of every second row: 75 000 are plenty for three numbers
constexpr std::size_t kLeastInliers = 50;
// The pixels that may lie on a plane, kept close together for several rounds of fitting.
struct Samples {
  std::vector<float> s, t, h, slack;  ///< In the plane, above it; one sigma of the height's noise.
};

// every stride-th row and pixel within reach of the plane; `axes` are the plane's tangents and normal, at `origin`
Samples gather(const OrganisedCloud& cloud, const Eigen::Matrix3f& axes, const Eigen::Vector3f& origin, float eye_height,
               const NoiseModel& noise, const GroundConfig& c, int stride) {
  const float sigma0 = static_cast<float>(noise.sigma0_m), sigma2 = static_cast<float>(noise.sigma2_per_m);
  const float base = kWidest * static_cast<float>(c.tolerance_m);
  const float factor = kWidest * static_cast<float>(c.tolerance_sigma);
  const std::size_t w = static_cast<std::size_t>(cloud.width());
  const std::size_t most = cloud.size() / static_cast<std::size_t>(stride * stride) + w;
  Samples out;
  for (auto* v : {&out.s, &out.t, &out.h, &out.slack}) v->resize(most);
  std::size_t n = 0;
  const Eigen::Vector3f es = axes.col(0), et = axes.col(1), en = axes.col(2);
  for (std::size_t row = 0; row < cloud.size(); row += w * static_cast<std::size_t>(stride)) {
    for (std::size_t i = row; i < row + w; i += static_cast<std::size_t>(stride)) {
      const float dx = cloud.x[i] - origin.x(), dy = cloud.y[i] - origin.y(), dz = cloud.z[i] - origin.z();
      const float d = cloud.depth_m[i];
      const float h = en.x() * dx + en.y() * dy + en.z() * dz;
      // depth noise enters the height by the slope of the ray: eye height over depth
      const float sigma = (sigma0 + sigma2 * d * d) * std::min(1.0f, eye_height / d);
      out.s[n] = es.x() * dx + es.y() * dy + es.z() * dz;
      out.t[n] = et.x() * dx + et.y() * dy + et.z() * dz;
      out.h[n] = h;
      out.slack[n] = sigma;
      n += std::abs(h) <= base + factor * sigma ? 1 : 0;  // false for a missing pixel
    }
  }
  for (auto* v : {&out.s, &out.t, &out.h, &out.slack}) v->resize(n);
  return out;
}

// Weighted least squares on the pixels. The tolerance starts wide, so that a crooked start finds its way, and shrinks, so
// that the rims of low objects fall out.
Ground refine(const Plane& start, const OrganisedCloud& cloud, const NoiseModel& noise, const GroundConfig& c) {
  const Vec3 eye = cloud.X_WC.translation();
  const auto [es, et] = hal::tangents(start.normal);
  const Vec3 origin = start.foot(eye);
  Eigen::Matrix3f axes;
  axes << es.cast<float>(), et.cast<float>(), start.normal.cast<float>();
  const Samples p = gather(cloud, axes, origin.cast<float>(), std::max(1e-3f, static_cast<float>(start.height(eye))),
                           noise, c, kFitStride);

  // the plane as a height over the start: h = a + b s + c t
  Eigen::Vector3f height = Eigen::Vector3f::Zero();
  std::size_t inliers = 0;
  double square = 0.0;
  for (const float width : {kWidest, 1.5f, 1.2f}) {
    const float factor = width * static_cast<float>(c.tolerance_sigma);
    const float base = width * static_cast<float>(c.tolerance_m);
    double sums[9] = {};  // w, ws, wt, wss, wst, wtt, wh, wsh, wth
    inliers = 0;
    square = 0.0;
    for (std::size_t i = 0; i < p.h.size(); ++i) {
      const float s = p.s[i], t = p.t[i], h = p.h[i], sigma = p.slack[i];
      const float rest = h - height[0] - height[1] * s - height[2] * t;
      const bool in = std::abs(rest) <= base + factor * sigma;
      const float w = in ? 1e-6f / (sigma * sigma + 1e-7f) : 0.0f;
      inliers += in;
      square += in ? rest * rest : 0.0f;
      sums[0] += w;
      sums[1] += w * s;
      sums[2] += w * t;
      sums[3] += w * s * s;
      sums[4] += w * s * t;
      sums[5] += w * t * t;
      sums[6] += w * h;
      sums[7] += w * s * h;
      sums[8] += w * t * h;
    }
    if (inliers < kLeastInliers) break;
    Eigen::Matrix3d A;
    A << sums[0], sums[1], sums[2], sums[1], sums[3], sums[4], sums[2], sums[4], sums[5];
    const Vec3 solved = A.ldlt().solve(Vec3(sums[6], sums[7], sums[8]));
    if (!solved.allFinite()) break;
    height = solved.cast<float>();
  }
  const Vec3 normal = (start.normal - height[1] * es - height[2] * et).normalized();
  const Plane plane{normal, -normal.dot(origin + height[0] * start.normal)};
  return {plane, inliers * kFitStride * kFitStride, inliers ? std::sqrt(square / static_cast<double>(inliers)) : 0.0};
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
