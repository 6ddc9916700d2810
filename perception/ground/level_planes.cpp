#include "perception/ground/level_planes.hpp"

#include <algorithm>
#include <cmath>

#include "hal/types/units.hpp"

namespace colift::perception {
namespace {

// what is left of a plane's evidence when too much lies below it: enough to be tried when nothing else is
// there
constexpr double kEvidenceOfTableTop = 0.02;

void weigh(LevelPlane& p, const std::vector<BlockPlane>& blocks, double total_m2, const Vec3& eye,
           const Vec3& up, bool up_known, const LevelPlaneConfig& c) {
  const Eigen::Vector3f n = p.voted.plane.normal.cast<float>(), eye_f = eye.cast<float>();
  const auto offset = static_cast<float>(p.voted.plane.offset);
  const auto margin = static_cast<float>(c.below_margin_m), sine = static_cast<float>(c.below_margin_sine);
  double below = 0.0, consistent = 0.0;
  for (const BlockPlane& b : blocks) {
    const float distance = (b.center - eye_f).norm();
    if (n.dot(b.center) + offset < -(margin + sine * distance)) below += b.area_m2;
    const double cosine = std::abs(n.dot(b.normal));
    if (cosine < c.upright_sine || cosine > c.level_cosine) consistent += b.area_m2;
  }
  p.below_fraction = below / total_m2;
  p.consistent_fraction = consistent / total_m2;
  p.tilt_deg = std::acos(std::clamp(p.voted.plane.normal.dot(up), -1.0, 1.0)) / hal::kRadPerDeg;
  const double tilt = p.tilt_deg / c.tilt_scale_deg;
  const double clear = 1.0 - p.below_fraction / std::max(1e-6, c.max_below_fraction);
  p.evidence = p.voted.area_m2 / total_m2 * (0.3 + p.consistent_fraction) *
               std::max(kEvidenceOfTableTop, clear) * (up_known ? 1.0 : std::exp(-tilt * tilt));
}

}  // namespace

std::vector<LevelPlane> order_level_planes(std::vector<VotedPlane> planes,
                                           const std::vector<BlockPlane>& blocks, const Vec3& eye_W,
                                           const Vec3& up_W, bool up_known, const LevelPlaneConfig& config) {
  double total = 1e-9;
  for (const BlockPlane& b : blocks) total += b.area_m2;
  std::vector<LevelPlane> out;
  out.reserve(planes.size());
  for (VotedPlane& p : planes) {
    out.push_back({std::move(p), 0.0, 0.0, 0.0, 0.0});
    weigh(out.back(), blocks, total, eye_W, up_W, up_known, config);
    const double area = out.back().voted.area_m2;
    if (area < std::max(config.min_area_m2, config.min_area_fraction * total) ||
        out.back().below_fraction > config.never_below_fraction)
      out.back().evidence = 0.0;
  }
  std::stable_sort(out.begin(), out.end(),
                   [](const LevelPlane& a, const LevelPlane& b) { return a.evidence > b.evidence; });
  return out;
}

}  // namespace colift::perception
