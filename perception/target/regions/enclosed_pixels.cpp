#include "perception/target/regions/enclosed_pixels.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "perception/footprint.hpp"

namespace colift::perception {
namespace {

constexpr std::size_t kHullStride = 7;  // the hull of every seventh pixel is within a pixel of the whole one

struct Window {
  int u0, v0, u1, v1;  // one pixel of margin around the object, so that the outside hangs together
  [[nodiscard]] int width() const { return u1 - u0 + 1; }
  [[nodiscard]] int height() const { return v1 - v0 + 1; }
};

// the pixels are ascending
Window window_of(const OrganisedCloud& cloud, const std::vector<std::uint32_t>& pixels) {
  const std::uint32_t w = static_cast<std::uint32_t>(cloud.width());
  const int top = static_cast<int>(pixels.front() / w), bottom = static_cast<int>(pixels.back() / w);
  std::uint32_t least = w, most = 0, row = static_cast<std::uint32_t>(top) * w;
  for (const std::uint32_t p : pixels) {
    while (p >= row + w) row += w;
    least = std::min(least, p - row);
    most = std::max(most, p - row);
  }
  return {std::max(0, static_cast<int>(least) - 1), std::max(0, top - 1),
          std::min(cloud.width() - 1, static_cast<int>(most) + 1), std::min(cloud.height() - 1, bottom + 1)};
}

// Stretches of neighbouring open pixels in the rows of a window, which hang together over their sides. A
// barrier is a pixel of the object, or a missing one: a shadow beside the rim is no door.
class OpenRuns {
 public:
  struct Run {
    int row, first, last;  // in the window
  };

  OpenRuns(const OrganisedCloud& cloud, const Window& win, const std::vector<std::uint32_t>& pixels)
      : outside_{0}, parent_{0} {
    const std::size_t w = static_cast<std::size_t>(win.width()),
                      width = static_cast<std::size_t>(cloud.width());
    std::vector<std::uint8_t> barrier(w);
    std::size_t next = 0, above = 0, above_end = 0;
    for (int v = 0; v < win.height(); ++v) {
      const std::size_t begin =
          static_cast<std::size_t>(v + win.v0) * width + static_cast<std::size_t>(win.u0);
      const float* d = cloud.depth_m.data() + begin;
      std::uint8_t* b = barrier.data();
      for (std::size_t u = 0; u < w; ++u) b[u] = d[u] == d[u] ? 0 : 1;
      for (; next < pixels.size() && pixels[next] < begin + w; ++next) b[pixels[next] - begin] = 1;

      const std::size_t row_begin = runs_.size();
      for (int u = find(b, 0, win.width(), 0); u < win.width();) {
        const int end = find(b, u, win.width(), 1);
        runs_.push_back({v, u, end - 1});
        // the window's margin is outside
        const bool rim = v == 0 || v == win.height() - 1 || u == 0 || end == win.width();
        parent_.push_back(rim ? outside_ : static_cast<std::int32_t>(runs_.size()));
        u = find(b, end, win.width(), 0);
      }
      for (std::size_t r = row_begin; r < runs_.size(); ++r) {
        while (above < above_end && runs_[above].last < runs_[r].first) ++above;
        for (std::size_t k = above; k < above_end && runs_[k].first <= runs_[r].last; ++k)
          unite(r + 1, k + 1);
      }
      above = row_begin;
      above_end = runs_.size();
    }
  }

  [[nodiscard]] const std::vector<Run>& runs() const { return runs_; }
  [[nodiscard]] bool enclosed(std::size_t run) {
    return root(static_cast<std::int32_t>(run + 1)) != outside_;
  }

 private:
  static int find(const std::uint8_t* row, int from, int to, std::uint8_t byte) {
    if (from >= to) return to;
    const void* at = std::memchr(row + from, byte, static_cast<std::size_t>(to - from));
    return at ? static_cast<int>(static_cast<const std::uint8_t*>(at) - row) : to;
  }
  std::int32_t root(std::int32_t i) {
    while (parent_[static_cast<std::size_t>(i)] != i) {
      const std::int32_t up = parent_[static_cast<std::size_t>(i)];
      parent_[static_cast<std::size_t>(i)] = parent_[static_cast<std::size_t>(up)];
      i = up;
    }
    return i;
  }
  void unite(std::size_t a, std::size_t b) {
    const std::int32_t i = root(static_cast<std::int32_t>(a)), k = root(static_cast<std::int32_t>(b));
    parent_[static_cast<std::size_t>(std::max(i, k))] = std::min(i, k);
  }

  std::int32_t outside_;
  std::vector<Run> runs_;
  std::vector<std::int32_t> parent_;  // union-find; entry 0 is the outside, entry i + 1 is run i
};

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
  const Window win = window_of(cloud, pixels);
  OpenRuns open(cloud, win, pixels);

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
      const std::size_t i = static_cast<std::size_t>((run.row + win.v0) * cloud.width() + u + win.u0);
      if (barred[i]) continue;
      const Vec3 p = cloud.point(i);
      if (ground.plane.height(p) > -config.max_below_ground_m && over_footprint(p) &&
          neighbours_of(cloud, u + win.u0, run.row + win.v0, jump) >= min_neighbours)
        enclosed.push_back(static_cast<std::uint32_t>(i));
    }
  }
  return enclosed;
}

}  // namespace colift::perception
