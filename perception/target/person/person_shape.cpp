#include "perception/target/person/person_shape.hpp"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

namespace colift::perception {
namespace {

using Point = Silhouette::Point;
using Thickness = std::function<double(const Silhouette::Window&)>;

double median_along(std::vector<Point>& points) {
  const auto middle = points.begin() + static_cast<std::ptrdiff_t>(points.size() / 2);
  std::nth_element(points.begin(), middle, points.end(),
                   [](const Point& a, const Point& b) { return a.along < b.along; });
  return middle->along;
}

// first and last bin around `at` in which the contour is at least `height` high
std::pair<std::size_t, std::size_t> contour_at(const std::vector<float>& top, std::size_t at, double height) {
  std::size_t from = at, to = at;
  while (from > 0 && top[from - 1] >= height) --from;
  while (to + 1 < top.size() && top[to + 1] >= height) ++to;
  return {from, to};
}

// the peak of the contour around bin `at`, judged as a head
std::optional<HeadAndShoulders> head_at(const Silhouette& s, std::size_t at, const NoiseModel& noise,
                                        const Thickness& thickness, const PersonShapeConfig& c) {
  const std::vector<float>& top = s.top();
  const double peak = top[at];
  if (peak < c.min_top_height_m) return std::nullopt;
  // A dome, not a cone: near its top a head is nearly as wide as above the shoulders. The contour only widens
  // downwards, so a neck shows as no growth.
  const double half = peak - c.min_head_rise_m;
  const auto [dome_from, dome_to] = contour_at(top, at, peak - 0.4 * c.min_head_rise_m);
  const auto [from, to] = contour_at(top, at, half);
  const double dome = static_cast<double>(dome_to - dome_from + 1) * Silhouette::kBin_m;
  const double width = static_cast<double>(to - from + 1) * Silhouette::kBin_m;
  if (dome < c.min_head_width_m || width > c.max_head_width_m || width > c.max_head_growth * dome)
    return std::nullopt;
  const auto [lowest, highest] = std::minmax_element(top.begin() + static_cast<std::ptrdiff_t>(dome_from),
                                                     top.begin() + static_cast<std::ptrdiff_t>(dome_to) + 1);
  if (static_cast<double>(*highest - *lowest) < c.min_head_arch_m) return std::nullopt;

  // shoulders: how far the contour reaches at the lowest height that a head leaves
  const double middle = s.across(0.5 * static_cast<double>(from + to));
  const auto reach = static_cast<std::size_t>(c.shoulder_reach_m / Silhouette::kBin_m);
  const std::size_t centre = (from + to) / 2;
  double left = 0.0, right = 0.0, sum = 0.0;
  std::size_t n = 0;
  for (std::size_t k = from; k-- > (centre > reach ? centre - reach : 0);) {
    if (top[k] < peak - c.max_head_rise_m) break;
    left += Silhouette::kBin_m;
    sum += top[k];
    ++n;
  }
  for (std::size_t k = to + 1; k < std::min(top.size(), centre + reach + 1); ++k) {
    if (top[k] < peak - c.max_head_rise_m) break;
    right += Silhouette::kBin_m;
    sum += top[k];
    ++n;
  }
  if (n == 0) return std::nullopt;
  const double shoulders = left + right + width;
  const double rise = peak - sum / static_cast<double>(n);
  if (shoulders < c.min_shoulder_width_m || shoulders < c.min_shoulder_ratio * width ||
      rise < c.min_head_rise_m)
    return std::nullopt;

  std::vector<Point> head = s.in({middle - 0.5 * width, middle + 0.5 * width, half, peak});
  if (head.size() < 20) return std::nullopt;
  const double distance = median_along(head);
  const double high = peak - rise, low = high - c.torso_length_m;
  const double side_from = middle - 0.5 * width - std::min(left, 0.12),
               side_to = middle + 0.5 * width + std::min(right, 0.12);
  const Silhouette::Window front{side_from, side_to, low, high};
  std::vector<Point> torso = s.in(front);
  std::erase_if(torso, [&](const Point& p) { return std::abs(p.along - distance) > c.max_torso_depth_m; });
  if (torso.size() < 50 || fill(torso, front) < c.min_torso_fill) return std::nullopt;
  // root mean square distance from the plane that fits best
  const double bend = spread(torso).deviation_m(0);
  if (bend < std::max(c.min_curvature_m, c.min_curvature_sigma * noise.sigma(distance)) ||
      bend > c.max_curvature_m)
    return std::nullopt;
  if (thickness(front) < c.min_torso_thickness_m) return std::nullopt;
  return HeadAndShoulders{
      s.place({static_cast<float>(middle), static_cast<float>(peak), static_cast<float>(distance)}), width,
      rise, shoulders, bend};
}

}  // namespace

std::optional<HeadAndShoulders> find_person(const Silhouette& s, const NoiseModel& noise,
                                            const Thickness& thickness, const PersonShapeConfig& config) {
  const std::vector<float>& top = s.top();
  for (std::size_t i = 0; i < top.size(); ++i) {
    const bool peak = (i == 0 || top[i] >= top[i - 1]) && (i + 1 == top.size() || top[i] > top[i + 1]);
    if (!peak) continue;
    if (auto found = head_at(s, i, noise, thickness, config)) return found;
  }
  return std::nullopt;
}

}  // namespace colift::perception
