#include "perception/shape/chair_back.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <set>
#include <utility>
#include <vector>

namespace colift::perception {
namespace {

constexpr double kAtSide = 0.6;  // of the half seat: points beyond stand over its side

// of sorted values
double quantile(const std::vector<double>& sorted, double p) {
  return sorted[static_cast<std::size_t>(p * static_cast<double>(sorted.size() - 1))];
}

// coordinates of the points above the seat, from its middle
struct Above {
  std::vector<double> out, across, height;
};

Above above_seat(const ShapeEvidence& seen, const Rectangle& seat, const Vec3& out,
                 const CompletionConfig& config) {
  const double seat_m = seen.ground().height(seat.center);
  const Vec3 across = seen.up().cross(out);
  Above points;
  for (const Eigen::Vector3f& point : seen.target().points) {
    const Vec3 p = point.cast<double>();
    const double height = seen.ground().height(p) - seat_m;
    if (height < config.min_back_height_m) continue;
    points.out.push_back(out.dot(p - seat.center));
    points.across.push_back(across.dot(p - seat.center));
    points.height.push_back(height);
  }
  return points;
}

// area of the cells that hold a point
double covered_m2(const Above& points, double cell_m) {
  std::set<std::pair<int, int>> cells;
  for (std::size_t i = 0; i < points.across.size(); ++i)
    cells.emplace(static_cast<int>(std::floor(points.across[i] / cell_m)),
                  static_cast<int>(std::floor(points.height[i] / cell_m)));
  return static_cast<double>(cells.size()) * cell_m * cell_m;
}

// where the points stand over the seat: 1 at its side
struct Side {
  Vec3 out = Vec3::UnitX();
  double part = 0.0;
};

Side side_along(const ShapeEvidence& seen, const Rectangle& seat, int axis, const CompletionConfig& config) {
  const Vec3& up = seen.up();
  const Vec3 u = (seat.u - up * up.dot(seat.u)).normalized();
  const Vec3 e = axis == 0 ? u : Vec3(up.cross(u));
  Above points = above_seat(seen, seat, e, config);
  if (points.out.empty()) return {};
  const auto middle = points.out.begin() + static_cast<std::ptrdiff_t>(points.out.size() / 2);
  std::nth_element(points.out.begin(), middle, points.out.end());
  const double part = *middle / (0.5 * seat.size[axis]);
  return {part > 0.0 ? e : Vec3(-e), std::abs(part)};
}

ChairBack back_at(const ShapeEvidence& seen, const Rectangle& seat, const Vec3& out,
                  const CompletionConfig& config) {
  Above points = above_seat(seen, seat, out, config);
  ChairBack back;
  back.out = out;
  const double facing = std::abs((seat.center - seen.eye()).normalized().dot(out));
  back.seen_from_front = facing > config.back_facing;
  const double covered = covered_m2(points, 2.0 * seen.pixel_m() / std::max(facing, config.back_facing));

  for (auto* values : {&points.out, &points.across, &points.height})
    std::sort(values->begin(), values->end());
  const bool along_u = std::abs(seat.u.dot(out)) > 0.5;
  const double seen_across = quantile(points.across, 0.98) - quantile(points.across, 0.02);
  back.width_m = std::max(seen_across, along_u ? seat.size.y() : seat.size.x());
  back.height_m = quantile(points.height, 0.98);
  back.fill = config.back_fill;
  double fill_sigma = config.back_fill_sigma;
  if (back.seen_from_front) {
    back.fill = std::clamp(covered / (back.width_m * back.height_m), 0.01, 1.0);
    fill_sigma *= 0.5;
  }
  back.relative_sigma = std::hypot(fill_sigma / back.fill, config.back_thickness_sigma);
  const double at = 0.5 * (quantile(points.out, 0.1) + quantile(points.out, 0.9));
  back.center = seat.center + at * out + 0.5 * back.height_m * seen.up();
  return back;
}

}  // namespace

std::optional<ChairBack> find_chair_back(const ShapeEvidence& seen, const Rectangle& seat,
                                         const CompletionConfig& config) {
  const std::array<Side, 2> sides{side_along(seen, seat, 0, config), side_along(seen, seat, 1, config)};
  const std::size_t first = sides[0].part >= sides[1].part ? 0 : 1;
  if (sides[first].part <= 0.0) return std::nullopt;
  ChairBack back = back_at(seen, seat, sides[first].out, config);
  if (!back.seen_from_front || back.fill >= config.min_back_fill) return back;
  // a back that faces the camera and is nearly empty is the post of one on the next side, seen from its edge
  const Side& next = sides[1 - first];
  if (next.part < kAtSide) return back;
  ChairBack other = back_at(seen, seat, next.out, config);
  const bool better = !other.seen_from_front || other.fill >= config.min_back_fill;
  return better ? other : back;
}

}  // namespace colift::perception
