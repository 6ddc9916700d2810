#include "perception/target/regions/open_runs.hpp"

#include <algorithm>
#include <cstring>

namespace colift::perception {
namespace {

struct Window {
  int u0, v0, u1, v1;  // one pixel of margin around the object, so that the outside hangs together
  [[nodiscard]] int width() const { return u1 - u0 + 1; }
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

int find(const std::uint8_t* row, int from, int to, std::uint8_t byte) {
  if (from >= to) return to;
  const void* at = std::memchr(row + from, byte, static_cast<std::size_t>(to - from));
  return at ? static_cast<int>(static_cast<const std::uint8_t*>(at) - row) : to;
}

}  // namespace

OpenRuns::OpenRuns(const OrganisedCloud& cloud, const std::vector<std::uint32_t>& pixels)
    : parent_{kOutside} {
  const Window win = window_of(cloud, pixels);
  const std::size_t w = static_cast<std::size_t>(win.width()),
                    width = static_cast<std::size_t>(cloud.width());
  std::vector<std::uint8_t> barrier(w);
  std::size_t next = 0, above = 0, above_end = 0;
  for (int v = win.v0; v <= win.v1; ++v) {
    const std::size_t begin = static_cast<std::size_t>(v) * width + static_cast<std::size_t>(win.u0);
    const float* d = cloud.depth_m.data() + begin;
    std::uint8_t* b = barrier.data();
    for (std::size_t u = 0; u < w; ++u) b[u] = d[u] == d[u] ? 0 : 1;
    for (; next < pixels.size() && pixels[next] < begin + w; ++next) b[pixels[next] - begin] = 1;

    const std::size_t row_begin = runs_.size();
    for (int u = find(b, 0, win.width(), 0); u < win.width();) {
      const int end = find(b, u, win.width(), 1);
      runs_.push_back({v, win.u0 + u, win.u0 + end - 1});
      // the window's margin is outside
      const bool rim = v == win.v0 || v == win.v1 || u == 0 || end == win.width();
      parent_.push_back(rim ? kOutside : static_cast<std::int32_t>(runs_.size()));
      u = find(b, end, win.width(), 0);
    }
    for (std::size_t r = row_begin; r < runs_.size(); ++r) {
      while (above < above_end && runs_[above].last < runs_[r].first) ++above;
      for (std::size_t k = above; k < above_end && runs_[k].first <= runs_[r].last; ++k) unite(r + 1, k + 1);
    }
    above = row_begin;
    above_end = runs_.size();
  }
}

std::int32_t OpenRuns::root(std::int32_t i) {
  while (parent_[static_cast<std::size_t>(i)] != i) {
    const std::int32_t up = parent_[static_cast<std::size_t>(i)];
    parent_[static_cast<std::size_t>(i)] = parent_[static_cast<std::size_t>(up)];
    i = up;
  }
  return i;
}

void OpenRuns::unite(std::size_t a, std::size_t b) {
  const std::int32_t i = root(static_cast<std::int32_t>(a)), k = root(static_cast<std::int32_t>(b));
  parent_[static_cast<std::size_t>(std::max(i, k))] = std::min(i, k);
}

int count_openings(const OrganisedCloud& cloud, const Components& components, const Fragment& object,
                   double min_area_m2) {
  const std::vector<std::uint8_t> own = own_pixels(cloud, components, object);
  std::vector<std::uint32_t> pixels;
  pixels.reserve(object.pixels);
  for (std::size_t i = 0; i < own.size(); ++i)
    if (own[i]) pixels.push_back(static_cast<std::uint32_t>(i));
  if (pixels.empty()) return 0;
  OpenRuns open(cloud, pixels);
  std::vector<int> area_px(open.runs().size() + 1, 0);
  for (std::size_t r = 0; r < open.runs().size(); ++r)
    area_px[static_cast<std::size_t>(open.opening(r))] += open.runs()[r].last - open.runs()[r].first + 1;
  area_px[OpenRuns::kOutside] = 0;
  const double pixel_m2 =
      object.mean_depth_m * object.mean_depth_m / (cloud.intrinsics.fx * cloud.intrinsics.fy);
  return static_cast<int>(std::count_if(area_px.begin(), area_px.end(),
                                        [&](int n) { return n > 0 && n * pixel_m2 >= min_area_m2; }));
}

}  // namespace colift::perception
