#include "perception/target/regions/enclosed_pixels.hpp"

#include <algorithm>
#include <cmath>

#include "perception/footprint.hpp"
#include "perception/target/regions/open_runs.hpp"

namespace colift::perception {
namespace {

constexpr std::size_t kHullStride = 7;  // the hull of every seventh pixel is within a pixel of the whole one

// neighbours of a pixel that lie on one surface with it; missing ones compare false
int neighbours_of(const OrganisedCloud& cloud, int u, int v, const DepthJump& jump) {
  const int w = cloud.width(), h = cloud.height();
  const float own = cloud.depth_m[static_cast<std::size_t>(v * w + u)];
  int count = 0;
  for (int y = std::max(0, v - 1); y <= std::min(h - 1, v + 1); ++y)
    for (int x = std::max(0, u - 1); x <= std::min(w - 1, u + 1); ++x)
      count +=
          (x != u || y != v) && jump.same_surface(own, cloud.depth_m[static_cast<std::size_t>(y * w + x)]);
  return count;
}

}  // namespace

std::vector<std::uint32_t> enclosed_pixels(const OrganisedCloud& cloud, const Ground& ground,
                                           const std::vector<std::uint32_t>& pixels,
                                           const std::vector<std::uint8_t>& barred, const DepthJump& jump,
                                           int min_neighbours, const EnclosedConfig& config) {
  if (pixels.empty()) return {};
  OpenRuns open(cloud, pixels);

  const auto axes = hal::tangents(ground.plane.normal);
  const Vec3 s = axes.first, t = axes.second;
  std::vector<Eigen::Vector2d> flat;
  for (std::size_t i = 0; i < pixels.size(); i += kHullStride) {
    const Vec3 p = cloud.point(pixels[i]);
    flat.emplace_back(s.dot(p), t.dot(p));
  }
  // the least rectangle and not the hull: it has the corner that the view hides
  const FlatRectangle r = minimum_area_rectangle(convex_hull(flat));
  const auto over_footprint = [&](const Vec3& p) {
    const Eigen::Vector2d d = Eigen::Vector2d(s.dot(p), t.dot(p)) - r.center;
    return std::abs(r.u.dot(d)) <= 0.5 * r.size.x() - config.footprint_inset_m &&
           std::abs(r.v().dot(d)) <= 0.5 * r.size.y() - config.footprint_inset_m;
  };

  std::vector<std::uint32_t> enclosed;
  for (std::size_t k = 0; k < open.runs().size(); ++k) {
    if (!open.enclosed(k)) continue;
    const OpenRuns::Run& run = open.runs()[k];
    for (int u = run.first; u <= run.last; ++u) {
      const std::size_t i = static_cast<std::size_t>(run.row * cloud.width() + u);
      if (barred[i]) continue;
      const Vec3 p = cloud.point(i);
      if (ground.plane.height(p) > -config.max_below_ground_m && over_footprint(p) &&
          neighbours_of(cloud, u, run.row, jump) >= min_neighbours)
        enclosed.push_back(static_cast<std::uint32_t>(i));
    }
  }
  return enclosed;
}

}  // namespace colift::perception
