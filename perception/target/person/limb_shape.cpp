#include "perception/target/person/limb_shape.hpp"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "perception/target/regions/open_runs.hpp"
#include "perception/target/regions/thickness.hpp"

namespace colift::perception {
namespace {

// a bar of uniform density has a standard deviation of its length / sqrt(12)
constexpr double kLengthPerDeviation = 3.4641;

struct Extent {
  double length_m = 0.0, slimness = 1.0, upward = 1.0;
  PointSpread spread;
};

// length of the longest axis, ratio of the next one to it, and how far it points up
Extent extent_of(const Silhouette& silhouette) {
  if (silhouette.points().empty()) return {};
  const PointSpread s = spread(silhouette.points());
  const double longest = std::max(1e-6, s.deviation_m(2));
  return {kLengthPerDeviation * longest, s.deviation_m(1) / longest, std::abs(s.axes.col(2).y()), s};
}

// Widths of an object at places along its longest axis: their median, and the range of the middle 80 % of
// them as a fraction of it. A pipe is as wide everywhere; between neck, shoulders and legs a person is not.
struct Widths {
  double median_m = 0.0, unevenness = 0.0;
};

Widths widths_along(const Silhouette& silhouette, const PointSpread& s, const Vec3& eye) {
  constexpr double kStep_m = 0.05;
  constexpr std::size_t kMinPoints = 5;
  const Vec3 axis = s.axes.col(2);
  const Vec3 view = s.mean - Vec3(0.0, (eye - silhouette.place({0.0F, 0.0F, 0.0F})).norm(), 0.0);
  const Vec3 aside = axis.cross(view).normalized();
  std::vector<std::pair<double, double>> places;  // along the axis, beside it
  places.reserve(silhouette.points().size());
  for (const Silhouette::Point& p : silhouette.points()) {
    const Vec3 q(p.across, p.height, p.along);
    places.emplace_back(axis.dot(q), aside.dot(q));
  }
  std::sort(places.begin(), places.end());
  std::vector<double> widths, beside;
  for (std::size_t i = 0; i < places.size();) {
    const double end = places[i].first + kStep_m;
    beside.clear();
    for (; i < places.size() && places[i].first < end; ++i) beside.push_back(places[i].second);
    if (beside.size() < kMinPoints) continue;
    std::sort(beside.begin(), beside.end());
    widths.push_back(beside[beside.size() * 19 / 20] - beside[beside.size() / 20]);
  }
  if (widths.empty()) return {};
  std::sort(widths.begin(), widths.end());
  const std::size_t n = widths.size();
  return {widths[n / 2], (widths[n * 9 / 10] - widths[n / 10]) / std::max(1e-3, widths[n / 2])};
}

// A pipe that lies, or leans a little. On blocks, or half hidden, it is wider here than there, but nowhere as
// wide as who lies on the floor.
bool is_pipe(const Silhouette& silhouette, const Vec3& eye, const Extent& extent, const LimbShapeConfig& c) {
  if (extent.slimness >= c.max_pipe_slimness || extent.upward >= c.max_pipe_upward) return false;
  const Widths widths = widths_along(silhouette, extent.spread, eye);
  return widths.median_m <= c.sure_pipe_width_m || widths.unevenness <= c.max_pipe_unevenness;
}

// Rails and rungs surround the ground more than once. Of what is higher, or goes on beyond the upper rim of
// the view, a person may be a part.
bool is_lying_frame(const OrganisedCloud& cloud, const Components& components, const Fragment& object,
                    const Extent& extent, double thickness_m, const LimbShapeConfig& c) {
  if (thickness_m > c.max_frame_thickness_m || object.cut_top > 0 ||
      object.max_height_m > c.max_frame_height_m || extent.upward >= c.max_pipe_upward)
    return false;
  return count_openings(cloud, components, object, c.min_opening_m2) >= c.min_openings;
}

}  // namespace

std::optional<LimbShape> find_limb(const OrganisedCloud& cloud, const Components& components,
                                   const Fragment& object, const Silhouette& silhouette,
                                   const NoiseModel& noise, const LimbShapeConfig& c) {
  const Extent extent = extent_of(silhouette);
  if (extent.length_m < c.min_length_m) return std::nullopt;
  if (is_pipe(silhouette, cloud.X_WC.translation(), extent, c)) return std::nullopt;
  const SurfaceCurvature s = surface_curvature(cloud, components, object, noise, c.curvature);
  // above the rim of the view there may be a head
  const double enough = object.cut_top > 0 ? c.headless : 1.0;
  if (s.pieces < c.min_pieces || s.measured < c.min_measured || s.convex < enough * c.min_convex)
    return std::nullopt;
  if (s.median_per_m < enough * c.min_curvature_per_m || s.median_per_m > c.max_curvature_per_m)
    return std::nullopt;
  if (s.median_per_m - 2 * s.sigma_per_m < enough * c.sure_curvature_per_m) return std::nullopt;
  const double thickness_m = median_thickness(cloud, components, object);
  if (thickness_m < c.min_thickness_m) return std::nullopt;
  if (is_lying_frame(cloud, components, object, extent, thickness_m, c)) return std::nullopt;
  return LimbShape{1.0 / s.median_per_m, extent.length_m};
}

}  // namespace colift::perception
