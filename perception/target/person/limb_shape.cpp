#include "perception/target/person/limb_shape.hpp"

#include <algorithm>
#include <cmath>

#include "perception/target/regions/thickness.hpp"

namespace colift::perception {
namespace {

// a bar of uniform density has a standard deviation of its length / sqrt(12)
constexpr double kLengthPerDeviation = 3.4641;

struct Extent {
  double length_m = 0.0, slimness = 1.0, upward = 1.0;
};

// length of the longest axis, ratio of the next one to it, and how far it points up
Extent extent_of(const Silhouette& silhouette) {
  if (silhouette.points().empty()) return {};
  const PointSpread s = spread(silhouette.points());
  const double longest = std::max(1e-6, s.deviation_m(2));
  return {kLengthPerDeviation * longest, s.deviation_m(1) / longest, std::abs(s.axes.col(2).y())};
}

}  // namespace

std::optional<LimbShape> find_limb(const OrganisedCloud& cloud, const Components& components,
                                   const Fragment& object, const Silhouette& silhouette,
                                   const NoiseModel& noise, const LimbShapeConfig& c) {
  const Extent extent = extent_of(silhouette);
  if (extent.length_m < c.min_length_m) return std::nullopt;
  if (extent.slimness < c.max_pipe_slimness && extent.upward < c.max_pipe_upward) return std::nullopt;
  const SurfaceCurvature s = surface_curvature(cloud, components, object, noise, c.curvature);
  // above the rim of the view there may be a head
  const double enough = object.cut_top > 0 ? c.headless : 1.0;
  if (s.pieces < c.min_pieces || s.measured < c.min_measured || s.convex < enough * c.min_convex)
    return std::nullopt;
  if (s.median_per_m < enough * c.min_curvature_per_m || s.median_per_m > c.max_curvature_per_m)
    return std::nullopt;
  if (s.median_per_m - 2 * s.sigma_per_m < enough * c.sure_curvature_per_m) return std::nullopt;
  if (median_thickness(cloud, components, object) < c.min_thickness_m) return std::nullopt;
  return LimbShape{1.0 / s.median_per_m, extent.length_m};
}

}  // namespace colift::perception
