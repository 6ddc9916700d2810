#include "perception/ground/ground.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "hal/types/symmetric.hpp"
#include "hal/types/units.hpp"
#include "perception/ground/plane_vote.hpp"

namespace colift::perception {
namespace {

// Tolerances of the rounds of the pixel fit, relative to the configured one: wide first, because the start is
// crooked, never less than the noise.
constexpr float kWidest = 2.0f;
constexpr std::array<float, 3> kWidths{kWidest, 1.5f, 1.2f};
// Guards against a plane through a handful of noisy pixels: three unknowns.
constexpr std::size_t kMinInliers = 50;
constexpr std::size_t kLanes = 4;  // floats in a register of plain x86-64

// The pixels that may lie on a plane, kept close together for several rounds of fitting.
struct Samples {
  std::vector<float> s, t, h, slack;  ///< In the plane, above it; one sigma of the height's noise.
};

// every stride-th row and pixel within reach of the plane; `axes` are the plane's tangents and normal, at
// `origin`
Samples gather(const OrganisedCloud& cloud, const Eigen::Matrix3f& axes, const Eigen::Vector3f& origin,
               float eye_height, const NoiseModel& noise, const GroundConfig& c, int stride) {
  const float sigma0 = static_cast<float>(noise.sigma0_m), sigma2 = static_cast<float>(noise.sigma2_per_m);
  const float base = kWidest * static_cast<float>(c.tolerance_m);
  const float factor = kWidest * static_cast<float>(c.tolerance_sigma);
  const std::size_t w = static_cast<std::size_t>(cloud.width());
  const Eigen::Vector3f es = axes.col(0), et = axes.col(1), en = axes.col(2);
  Samples out;
  const std::array<std::vector<float>*, 4> arrays{&out.s, &out.t, &out.h, &out.slack};
  for (auto* v : arrays) v->reserve(cloud.size() / static_cast<std::size_t>(stride * stride) + w + kLanes);
  Eigen::ArrayXf height(cloud.width()), noise_of(cloud.width()), beyond(cloud.width());
  std::vector<std::size_t> found(w);
  std::vector<float> rows(4 * w);
  float *row_s = rows.data(), *row_t = row_s + w, *row_h = row_t + w, *row_slack = row_h + w;
  const float *px = cloud.x.data(), *py = cloud.y.data(), *pz = cloud.z.data();
  const float ox = origin.x(), oy = origin.y(), oz = origin.z(), sx = es.x(), sy = es.y(), sz = es.z(),
              tx = et.x(), ty = et.y(), tz = et.z();
  using Row = Eigen::Map<const Eigen::ArrayXf>;
  for (std::size_t row = 0; row < cloud.size(); row += w * static_cast<std::size_t>(stride)) {
    const Row d(cloud.depth_m.data() + row, cloud.width()), x(cloud.x.data() + row, cloud.width()),
        y(cloud.y.data() + row, cloud.width()), z(cloud.z.data() + row, cloud.width());
    height = en.x() * (x - origin.x()) + en.y() * (y - origin.y()) + en.z() * (z - origin.z());
    // depth noise enters the height by the slope of the ray: eye height over depth
    noise_of = (sigma0 + sigma2 * d * d) * (eye_height / d).min(1.0f);
    beyond = height.abs() - (base + factor * noise_of);
    std::size_t n = 0;
    for (std::size_t u = 0; u < w; u += static_cast<std::size_t>(stride)) {
      found[n] = u;
      n += beyond[static_cast<Eigen::Index>(u)] <= 0.0f ? 1 : 0;  // false for a missing pixel
    }
    for (std::size_t k = 0; k < n; ++k) {
      const std::size_t u = found[k], i = row + u;
      const float dx = px[i] - ox, dy = py[i] - oy, dz = pz[i] - oz;
      row_s[k] = sx * dx + sy * dy + sz * dz;
      row_t[k] = tx * dx + ty * dy + tz * dz;
      row_h[k] = height[static_cast<Eigen::Index>(u)];
      row_slack[k] = noise_of[static_cast<Eigen::Index>(u)];
    }
    out.s.insert(out.s.end(), row_s, row_s + n);
    out.t.insert(out.t.end(), row_t, row_t + n);
    out.h.insert(out.h.end(), row_h, row_h + n);
    out.slack.insert(out.slack.end(), row_slack, row_slack + n);
  }
  // up to whole lanes with samples that are far from every plane
  while (out.s.size() % kLanes != 0) {
    out.s.push_back(0.0f);
    out.t.push_back(0.0f);
    out.h.push_back(1e6f);
    out.slack.push_back(1.0f);
  }
  return out;
}

// Sums of weighted least squares for a plane h = a + b s + c t over the samples near the last one.
struct FitSums {
  std::array<double, 9> sum{};  // w, ws, wt, wss, wst, wtt, wh, wsh, wth
  double square = 0.0;          // of the distances
  std::size_t inliers = 0;
};

FitSums fit_sums(const Samples& p, const Eigen::Vector3f& last, float base, float factor) {
  // in single precision over a few samples at a time, so that the compiler can keep four sums in a register
  constexpr std::size_t kBatch = 16 * kLanes;
  using Lane = Eigen::Array<float, kLanes, 1>;
  FitSums out;
  std::array<float, kBatch> weight{}, inside{}, squared{};
  for (std::size_t begin = 0; begin < p.h.size(); begin += kBatch) {
    const std::size_t n = std::min(kBatch, p.h.size() - begin);
    const float *s = p.s.data() + begin, *t = p.t.data() + begin, *h = p.h.data() + begin,
                *sigma = p.slack.data() + begin;
    const float a = last[0], b = last[1], c = last[2];
    for (std::size_t i = 0; i < n; ++i) {
      const float rest = h[i] - a - b * s[i] - c * t[i];
      inside[i] = std::abs(rest) <= base + factor * sigma[i] ? 1.0f : 0.0f;
      weight[i] = inside[i] * (1e-6f / (sigma[i] * sigma[i] + 1e-7f));
      squared[i] = inside[i] * rest * rest;
    }
    std::array<Lane, 9> sums;
    sums.fill(Lane::Zero());
    Lane count = Lane::Zero(), square = Lane::Zero();
    for (std::size_t i = 0; i < n; i += kLanes) {
      const Eigen::Map<const Lane> lane_s(s + i), lane_t(t + i), lane_h(h + i), w(weight.data() + i);
      const Lane ws = w * lane_s, wt = w * lane_t;
      sums[0] += w;
      sums[1] += ws;
      sums[2] += wt;
      sums[3] += ws * lane_s;
      sums[4] += ws * lane_t;
      sums[5] += wt * lane_t;
      sums[6] += w * lane_h;
      sums[7] += ws * lane_h;
      sums[8] += wt * lane_h;
      count += Eigen::Map<const Lane>(inside.data() + i);
      square += Eigen::Map<const Lane>(squared.data() + i);
    }
    for (std::size_t k = 0; k < sums.size(); ++k) out.sum[k] += static_cast<double>(sums[k].sum());
    out.square += static_cast<double>(square.sum());
    out.inliers += static_cast<std::size_t>(count.sum());
  }
  return out;
}

// Weighted least squares on the pixels. The tolerance starts wide, so that a crooked start finds its way, and
// shrinks, so that the rims of low objects fall out.
Ground refine(const Plane& start, const OrganisedCloud& cloud, const NoiseModel& noise,
              const GroundConfig& c) {
  const Vec3 eye = cloud.X_WC.translation();
  const auto [es, et] = hal::tangents(start.normal);
  const Vec3 origin = start.foot(eye);
  Eigen::Matrix3f axes;
  axes << es.cast<float>(), et.cast<float>(), start.normal.cast<float>();
  const Samples p = gather(cloud, axes, origin.cast<float>(),
                           std::max(1e-3f, static_cast<float>(start.height(eye))), noise, c, c.fit_stride);

  // the plane as a height over the start: h = a + b s + c t
  Eigen::Vector3f height = Eigen::Vector3f::Zero();
  std::size_t inliers = 0;
  double square = 0.0;
  for (const float width : kWidths) {
    const float factor = width * static_cast<float>(c.tolerance_sigma);
    const float base = width * static_cast<float>(c.tolerance_m);
    const FitSums fit = fit_sums(p, height, base, factor);
    const auto& sums = fit.sum;
    inliers = fit.inliers;
    square = fit.square;
    if (inliers < kMinInliers) break;
    Eigen::Matrix3d A;
    A << sums[0], sums[1], sums[2], sums[1], sums[3], sums[4], sums[2], sums[4], sums[5];
    const Vec3 solved = hal::solve_symmetric(A, Vec3(sums[6], sums[7], sums[8]));
    if (!solved.allFinite()) break;
    height = solved.cast<float>();
  }
  const Vec3 normal = (start.normal - height[1] * es - height[2] * et).normalized();
  const Plane plane{normal, -normal.dot(origin + height[0] * start.normal)};
  const auto stride = static_cast<std::size_t>(c.fit_stride);
  return {plane, inliers * stride * stride, inliers ? std::sqrt(square / static_cast<double>(inliers)) : 0.0};
}

// part of the pixels in view that lie below a plane: curved and rough things are in no flat block
double below(const Plane& plane, const OrganisedCloud& cloud, const LevelPlaneConfig& c) {
  constexpr std::size_t kStride = 37;  // prime: no pattern of columns
  const Vec3 eye = cloud.X_WC.translation();
  std::size_t all = 0, under = 0;
  for (std::size_t i = 0; i < cloud.size(); i += kStride) {
    if (!cloud.seen(i)) continue;
    ++all;
    const Vec3 p = cloud.point(i);
    under += plane.height(p) < -(c.below_margin_m + c.below_margin_sine * (p - eye).norm()) ? 1 : 0;
  }
  return all ? static_cast<double>(under) / static_cast<double>(all) : 0.0;
}

// level planes at a table's height above the ground, largest first
std::vector<Plane> tables_over(const Ground& ground, const std::vector<LevelPlane>& level,
                               const GroundConfig& c) {
  std::vector<const VotedPlane*> found;
  for (const LevelPlane& p : level) {
    const Plane& plane = p.voted.plane;
    if (p.voted.area_m2 < c.min_table_area_m2) continue;
    if (plane.normal.dot(ground.plane.normal) < std::cos(c.max_table_tilt_deg * hal::kRadPerDeg)) continue;
    Vec3 middle = Vec3::Zero();
    for (const BlockPlane* b : p.voted.blocks) middle += b->center.cast<double>();
    const double height = ground.plane.height(middle / static_cast<double>(p.voted.blocks.size()));
    if (height >= c.min_table_height_m && height <= c.max_table_height_m) found.push_back(&p.voted);
  }
  std::stable_sort(found.begin(), found.end(),
                   [](const auto* a, const auto* b) { return a->area_m2 > b->area_m2; });
  std::vector<Plane> out;
  out.reserve(found.size());
  for (const VotedPlane* p : found) out.push_back(p->plane);
  return out;
}

}  // namespace

GroundResult find_ground(const OrganisedCloud& cloud, const std::vector<BlockPlane>& blocks,
                         const std::optional<Vec3>& up_W, const NoiseModel& noise, const GroundConfig& c) {
  std::uint32_t seen = 0;  // narrow, so that the loop counts four at a time
  for (const float d : cloud.depth_m) seen += d == d ? 1U : 0U;
  const Vec3 up = up_W.value_or(-cloud.X_WC.linear().col(1));
  const double max_tilt_deg = up_W ? c.max_tilt_deg : c.max_tilt_unknown_deg;
  const auto faces_up = [&](const Vec3& n) { return n.dot(up) > std::cos(max_tilt_deg * hal::kRadPerDeg); };

  std::vector<VotedPlane> voted =
      vote_planes(blocks, faces_up, noise, {c.tolerance_m, c.tolerance_sigma}, c.vote);
  if (voted.empty()) {
    return {std::nullopt,
            fmt::format("no ground: none of {} flat image blocks lie on a plane that faces up within "
                        "{:.0f} degrees",
                        blocks.size(), max_tilt_deg),
            {}};
  }
  const Vec3 eye = cloud.X_WC.translation();
  const std::vector<LevelPlane> level =
      order_level_planes(std::move(voted), blocks, eye, up, up_W.has_value(), c.level);

  if (level.front().evidence <= 0.0)
    return {std::nullopt,
            fmt::format(
                "no ground: of the level planes in view none covers {:.2f} m^2 and {:.0f} % of the flat area "
                "without more than {:.0f} % of it below",
                c.level.min_area_m2, 100 * c.level.min_area_fraction, 100 * c.level.never_below_fraction),
            {}};
  std::size_t most = 0;
  for (std::size_t k = 0; k < std::min(level.size(), static_cast<std::size_t>(c.max_tries)); ++k) {
    if (level[k].evidence <= 0.0) break;
    const Ground ground = refine(level[k].voted.plane, cloud, noise, c);
    most = std::max(most, ground.inliers);
    if (static_cast<double>(ground.inliers) < c.min_image_fraction * static_cast<double>(seen)) continue;
    if (below(ground.plane, cloud, c.level) > c.level.never_below_fraction) continue;
    return {ground,
            fmt::format("ground: {} pixels within {:.1f} mm rms, camera {:.2f} m above it", ground.inliers,
                        1000 * ground.rms_m, ground.plane.height(eye)),
            tables_over(ground, level, c)};
  }
  return {std::nullopt,
          fmt::format("no ground: the best level plane explains {} of {} seen pixels, {:.0f} % are needed",
                      most, seen, 100 * c.min_image_fraction),
          {}};
}

Ground refine_table(const Plane& table, const OrganisedCloud& cloud, const NoiseModel& noise,
                    const GroundConfig& config) {
  return refine(table, cloud, noise, config);
}

}  // namespace colift::perception
