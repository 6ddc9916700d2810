#include "perception/enclosed_pixels.hpp"

#include <algorithm>
#include <cmath>

#include "perception/footprint.hpp"

namespace colift::perception {
namespace {

constexpr std::size_t kHullStride = 7;  // the hull of every seventh pixel is within a pixel of the whole one
constexpr double kShrink_m = 0.01;      // the floor just outside the rim is not inside
constexpr double kBelow_m = 0.01;       // a ground pixel's noise

struct Window {
  int u0, v0, u1, v1;  // one pixel of margin around the object, so that the outside hangs together
  [[nodiscard]] int width() const { return u1 - u0 + 1; }
  [[nodiscard]] int height() const { return v1 - v0 + 1; }
};

Window window_of(const OrganisedCloud& cloud, const std::vector<std::uint32_t>& pixels) {
  Window b{1 << 20, 1 << 20, -1, -1};
  for (const std::uint32_t p : pixels) {
    const int u = static_cast<int>(p) % cloud.width(), v = static_cast<int>(p) / cloud.width();
    b = {std::min(b.u0, u), std::min(b.v0, v), std::max(b.u1, u), std::max(b.v1, v)};
  }
  return {std::max(0, b.u0 - 1), std::max(0, b.v0 - 1), std::min(cloud.width() - 1, b.u1 + 1),
          std::min(cloud.height() - 1, b.v1 + 1)};
}

}  // namespace

std::vector<std::uint32_t> enclosed_pixels(const OrganisedCloud& cloud, const Ground& ground,
                                           const std::vector<std::uint32_t>& pixels,
                                           const std::vector<std::uint8_t>& barred) {
  if (pixels.empty()) return {};
  const Window win = window_of(cloud, pixels);
  const int w = win.width(), h = win.height();
  // a missing pixel stops the flood too: a shadow beside the rim is no door
  enum : std::uint8_t { kOpen, kBarrier, kOutside };
  std::vector<std::uint8_t> state(static_cast<std::size_t>(w * h), kOpen);
  for (int v = 0; v < h; ++v)
    for (int u = 0; u < w; ++u)
      if (!cloud.seen(static_cast<std::size_t>((v + win.v0) * cloud.width() + u + win.u0)))
        state[static_cast<std::size_t>(v * w + u)] = kBarrier;
  for (const std::uint32_t p : pixels) {
    const int u = static_cast<int>(p) % cloud.width() - win.u0, v = static_cast<int>(p) / cloud.width() - win.v0;
    state[static_cast<std::size_t>(v * w + u)] = kBarrier;
  }

  std::vector<int> open;
  const auto visit = [&](int u, int v) {
    std::uint8_t& s = state[static_cast<std::size_t>(v * w + u)];
    if (s != kOpen) return;
    s = kOutside;
    open.push_back(v * w + u);
  };
  for (int u = 0; u < w; ++u) visit(u, 0), visit(u, h - 1);
  for (int v = 0; v < h; ++v) visit(0, v), visit(w - 1, v);
  while (!open.empty()) {
    const int u = open.back() % w, v = open.back() / w;
    open.pop_back();
    if (u > 0) visit(u - 1, v);
    if (u + 1 < w) visit(u + 1, v);
    if (v > 0) visit(u, v - 1);
    if (v + 1 < h) visit(u, v + 1);
  }

  const auto [s, t] = hal::tangents(ground.plane.normal);
  std::vector<Eigen::Vector2d> flat;
  for (std::size_t i = 0; i < pixels.size(); i += kHullStride) {
    const Vec3 p = cloud.point(pixels[i]);
    flat.emplace_back(s.dot(p), t.dot(p));
  }
  // the least rectangle and not the hull: it has the corner that the view hides
  const FlatRectangle r = minimum_area_rectangle(convex_hull(flat));
  const auto over_footprint = [&](const Vec3& p) {
    const Eigen::Vector2d d = Eigen::Vector2d(s.dot(p), t.dot(p)) - r.center;
    return std::abs(r.u.dot(d)) <= 0.5 * r.size.x() - kShrink_m && std::abs(r.v().dot(d)) <= 0.5 * r.size.y() - kShrink_m;
  };

  std::vector<std::uint32_t> enclosed;
  for (int v = 0; v < h; ++v) {
    for (int u = 0; u < w; ++u) {
      if (state[static_cast<std::size_t>(v * w + u)] != kOpen) continue;
      const std::size_t i = static_cast<std::size_t>((v + win.v0) * cloud.width() + u + win.u0);
      if (barred[i]) continue;
      const Vec3 p = cloud.point(i);
      if (ground.plane.height(p) > -kBelow_m && over_footprint(p)) enclosed.push_back(static_cast<std::uint32_t>(i));
    }
  }
  return enclosed;
}

}  // namespace colift::perception
