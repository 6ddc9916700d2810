#include "perception/target/person/limb_shape.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
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

// What an object looks like along its longest axis, in slices.
struct Profile {
  double median_width_m = 0.0;
  double unevenness = 0.0;  // range of the middle 80 % of the widths, as a fraction of their median
  double ridge_m = 0.0;     // range of the middle 80 % of the slices' tops about a straight line
};

// range of the middle 80 % of ascending values
double middle_range(const std::vector<double>& sorted) {
  return sorted[sorted.size() * 9 / 10] - sorted[sorted.size() / 10];
}

// of heights at places, without the line that fits best
std::vector<double> off_line(const std::vector<double>& at, const std::vector<double>& height) {
  const auto n = static_cast<Eigen::Index>(at.size());
  const Eigen::Map<const Eigen::ArrayXd> x(at.data(), n), y(height.data(), n);
  const Eigen::ArrayXd from_mean = x - x.mean();
  const double slope = (from_mean * y).sum() / std::max(1e-9, from_mean.square().sum());
  const Eigen::ArrayXd rest = y - y.mean() - slope * from_mean;
  return {rest.begin(), rest.end()};
}

Profile profile_along(const Silhouette& silhouette, const PointSpread& s, const Vec3& eye) {
  constexpr double kStep_m = 0.05;
  constexpr std::size_t kMinPoints = 5;
  const Vec3 axis = s.axes.col(2);
  const Vec3 view = s.mean - Vec3(0.0, (eye - silhouette.place({0.0F, 0.0F, 0.0F})).norm(), 0.0);
  const Vec3 aside = axis.cross(view).normalized();
  struct Place {
    double along, beside, height;
  };
  std::vector<Place> places;
  places.reserve(silhouette.points().size());
  for (const Silhouette::Point& p : silhouette.points()) {
    const Vec3 q(p.across, p.height, p.along);
    places.push_back({axis.dot(q), aside.dot(q), p.height});
  }
  std::sort(places.begin(), places.end(), [](const Place& l, const Place& r) { return l.along < r.along; });
  std::vector<double> at, widths, tops, beside, heights;
  for (std::size_t i = 0; i < places.size();) {
    const double end = places[i].along + kStep_m;
    beside.clear();
    heights.clear();
    for (; i < places.size() && places[i].along < end; ++i) {
      beside.push_back(places[i].beside);
      heights.push_back(places[i].height);
    }
    if (beside.size() < kMinPoints) continue;
    std::sort(beside.begin(), beside.end());
    std::sort(heights.begin(), heights.end());
    at.push_back(end);
    widths.push_back(beside[beside.size() * 19 / 20] - beside[beside.size() / 20]);
    tops.push_back(heights[heights.size() * 19 / 20]);
  }
  if (widths.empty()) return {};
  std::vector<double> ridge = off_line(at, tops);
  std::sort(ridge.begin(), ridge.end());
  std::sort(widths.begin(), widths.end());
  const double median = widths[widths.size() / 2];
  return {median, middle_range(widths) / std::max(1e-3, median), middle_range(ridge)};
}

// A pipe that lies, or leans a little: its upper side is straight. On blocks, or half hidden, it is wider
// here than there, but nowhere as wide as who lies on the floor.
bool is_pipe(const Silhouette& silhouette, const Vec3& eye, const Extent& extent, double sigma_m,
             const LimbShapeConfig& c) {
  if (extent.slimness >= c.max_pipe_slimness || extent.upward >= c.max_pipe_upward) return false;
  const Profile profile = profile_along(silhouette, extent.spread, eye);
  if (profile.ridge_m > std::max(c.max_pipe_ridge_m, c.max_pipe_ridge_sigma * sigma_m)) return false;
  return profile.median_width_m <= c.sure_pipe_width_m || profile.unevenness <= c.max_pipe_unevenness;
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

// What is seen of its upper side, from its robust top down to `slab_m` below it, over the ground.
std::vector<Silhouette::Point> upper_part(const Silhouette& silhouette, double slab_m) {
  std::vector<Silhouette::Point> part = silhouette.points();
  const auto high = part.begin() + static_cast<std::ptrdiff_t>(part.size() - 1 - part.size() / 100);
  std::nth_element(part.begin(), high, part.end(),
                   [](const auto& l, const auto& r) { return l.height < r.height; });
  const double top_m = high->height;
  std::erase_if(part, [&](const auto& p) { return p.height < top_m - slab_m; });
  for (auto& p : part) p.height = 0.0F;
  return part;
}

// The upper side of a level beam: its middle, its axis, and its length by their spread.
struct Beam {
  PointSpread spread;
  double length_m = 0.0, width_m = 0.0;

  explicit Beam(const std::vector<Silhouette::Point>& upper)
      : spread(perception::spread(upper)),
        length_m(kLengthPerDeviation * spread.deviation_m(2)),
        width_m(kLengthPerDeviation * spread.deviation_m(1)) {}
  [[nodiscard]] std::size_t slices() const {
    constexpr double kStep_m = 0.05;
    return static_cast<std::size_t>(length_m / kStep_m);
  }
  /// Of slices(), and where across the axis; nothing beyond the ends.
  struct Place {
    std::size_t slice;
    double aside_m;
  };
  [[nodiscard]] std::optional<Place> place_of(const Silhouette::Point& p) const {
    const Vec3 d = Vec3(p.across, 0.0, p.along) - spread.mean;
    const double at = spread.axes.col(2).dot(d) / length_m + 0.5;
    if (!(at >= 0.0 && at < 1.0)) return std::nullopt;
    return Place{static_cast<std::size_t>(at * static_cast<double>(slices())), spread.axes.col(1).dot(d)};
  }
};

// The middle of a level beam on legs is longer, and narrower, than any back.
bool is_beam_on_legs(const Silhouette& silhouette, double slab_m, const LimbShapeConfig& c) {
  constexpr double kFilled = 0.85;
  const std::vector<Silhouette::Point> upper = upper_part(silhouette, slab_m);
  const Beam beam(upper);
  if (beam.width_m > c.max_beam_width_m || beam.length_m < c.min_beam_length_m) return false;
  // one beam, not two heads
  std::vector<bool> filled(beam.slices(), false);
  for (const Silhouette::Point& p : upper)
    if (const auto at = beam.place_of(p)) filled[at->slice] = true;
  const auto n = static_cast<double>(std::count(filled.begin(), filled.end(), true));
  return n >= kFilled * static_cast<double>(filled.size());
}

// A pipe on stands that are too wide, or too high, for is_pipe(). Of who lies on the floor no part as long as
// a beam is clear of it, and nothing beside it is as high and no wider.
bool is_beam_in_the_air(const Silhouette& silhouette, const LimbShapeConfig& c) {
  // the stands begin a diameter below the top; two of 0.2 m carry a beam of 0.7 m at least
  constexpr double kSlab_m = 0.05, kMinInAir = 0.4;
  // 2 x 60 mm, and the noise at 2.5 m
  constexpr double kMaxBar_m = 0.16;
  constexpr double kClear_m = 0.08;  // what a lying limb shows of its lower side is lower than its own radius
  if (!is_beam_on_legs(silhouette, kSlab_m, c)) return false;
  const Beam beam(upper_part(silhouette, kSlab_m));
  struct Slice {
    double lowest_m = std::numeric_limits<double>::infinity(), left_m = lowest_m, right_m = -lowest_m;
  };
  std::vector<Slice> slices(beam.slices());
  for (const Silhouette::Point& p : silhouette.points()) {
    const auto at = beam.place_of(p);
    if (!at) continue;
    Slice& s = slices[at->slice];
    s.lowest_m = std::min(s.lowest_m, static_cast<double>(p.height));
    s.left_m = std::min(s.left_m, at->aside_m);
    s.right_m = std::max(s.right_m, at->aside_m);
  }
  // between the stands it is a bar, whatever of it is seen
  const auto in_air = std::count_if(slices.begin(), slices.end(), [&](const Slice& s) {
    return s.lowest_m > kClear_m && s.right_m - s.left_m <= kMaxBar_m && s.right_m > s.left_m;
  });
  return static_cast<double>(in_air) >= kMinInAir * static_cast<double>(slices.size());
}

// A drum, or a bin with its lid: a level disc on top covers all of it. Shoulders and backs are neither level
// nor all of a person.
bool is_under_its_top(const Silhouette& silhouette, double sigma_m, const LimbShapeConfig& c) {
  constexpr double kCell_m = 0.04;
  if (sigma_m > c.max_top_sigma_m) return false;
  const std::vector<Silhouette::Point> top = upper_part(silhouette, c.top_slab_m);
  if (kLengthPerDeviation * spread(top).deviation_m(1) < c.min_top_width_m) return false;
  const auto cells = [](const std::vector<Silhouette::Point>& points) {
    std::vector<std::pair<long, long>> all;
    for (const Silhouette::Point& p : points)
      all.emplace_back(std::lround(p.across / kCell_m), std::lround(p.along / kCell_m));
    std::sort(all.begin(), all.end());
    return std::distance(all.begin(), std::unique(all.begin(), all.end()));
  };
  return static_cast<double>(cells(top)) >= c.min_top_cover * static_cast<double>(cells(silhouette.points()));
}

// Nearly all that could be measured is round; `enough`: factor of the limits.
bool is_round(const SurfaceCurvature& s, double enough, const LimbShapeConfig& c) {
  return s.pieces >= c.min_pieces && s.measured >= c.min_measured && s.convex >= enough * c.min_convex;
}

// Little could be measured, but that is as round as a bar of the object's own thickness. Tables and chairs,
// whose legs are the only round parts, are thinner.
bool is_round_bar(const SurfaceCurvature& s, double thickness_m, const LimbShapeConfig& c) {
  const double diameters = s.median_per_m * thickness_m;  // of a cylinder: 2
  return s.pieces >= c.min_bar_pieces && s.measured >= c.min_bar_measured &&
         thickness_m >= c.min_bar_thickness_m && s.convex >= c.min_bar_convex &&
         diameters >= c.min_bar_diameters && diameters <= c.max_bar_diameters;
}

}  // namespace

std::optional<LimbShape> find_limb(const OrganisedCloud& cloud, const Components& components,
                                   const Fragment& object, const Silhouette& silhouette,
                                   const NoiseModel& noise, const LimbShapeConfig& c) {
  const Extent extent = extent_of(silhouette);
  if (std::max(extent.length_m, object.max_height_m) < c.min_length_m) return std::nullopt;
  if (is_pipe(silhouette, cloud.X_WC.translation(), extent, noise.sigma(object.mean_depth_m), c))
    return std::nullopt;
  const SurfaceCurvature s = surface_curvature(cloud, components, object, noise, c.curvature);
  // above the rim of the view there may be a head
  const double headless = object.cut_top > 0 ? c.headless : 1.0;
  if (s.pieces == 0 || s.median_per_m < headless * c.min_curvature_per_m ||
      s.median_per_m > c.max_curvature_per_m)
    return std::nullopt;
  const double thickness_m = median_thickness(cloud, components, object);
  if (thickness_m < c.min_thickness_m) return std::nullopt;
  const bool bar = is_round_bar(s, thickness_m, c);
  if (!bar && !is_round(s, headless, c)) return std::nullopt;
  const double enough = bar ? 1.0 : headless;
  if (s.median_per_m < enough * c.min_curvature_per_m ||
      s.median_per_m - 2 * s.sigma_per_m < enough * c.sure_curvature_per_m)
    return std::nullopt;
  if (is_lying_frame(cloud, components, object, extent, thickness_m, c)) return std::nullopt;
  if (object.cut_top == 0 && object.max_height_m > c.min_on_legs_m &&
      (is_beam_on_legs(silhouette, c.beam_slab_m, c) ||
       is_under_its_top(silhouette, noise.sigma(object.mean_depth_m), c)))
    return std::nullopt;
  // what goes on beyond the view may be anything
  const bool whole = object.cut_top + object.cut_left + object.cut_right + object.cut_bottom == 0;
  if (whole && is_beam_in_the_air(silhouette, c)) return std::nullopt;
  return LimbShape{1.0 / s.median_per_m, extent.length_m};
}

}  // namespace colift::perception
