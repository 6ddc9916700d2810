#include "perception/ground/image_border.hpp"

#include <algorithm>

namespace colift::perception {
namespace {

// pixels; a wider gap is a hole in the scene and not a margin (43 columns and 29 rows were seen in registered
// frames)
constexpr int kWidestSide = 44;
constexpr int kWidestEnd = 30;
constexpr int kNeighbourhood =
    12;  // rows or columns that share a margin: it slants by less than a pixel over these

// the outermost seen pixel of a line is a rim only if its neighbours agree: an object before nothing is no
// rim
void settle(std::vector<int>& rim, int image_edge, int widest, bool low) {
  std::vector<int> agreed(rim.size());
  const int n = static_cast<int>(rim.size());
  for (int i = 0; i < n; ++i) {
    int best = rim[static_cast<std::size_t>(i)];
    for (int k = std::max(0, i - kNeighbourhood); k <= std::min(n - 1, i + kNeighbourhood); ++k) {
      const int r = rim[static_cast<std::size_t>(k)];
      best = low ? std::min(best, r) : std::max(best, r);
    }
    const int margin = low ? best - image_edge : image_edge - best;
    agreed[static_cast<std::size_t>(i)] = margin <= widest ? best : image_edge;
  }
  rim = std::move(agreed);
}

}  // namespace

ImageBorder find_image_border(const OrganisedCloud& cloud) {
  const int w = cloud.width(), h = cloud.height();
  ImageBorder b;
  b.left.assign(static_cast<std::size_t>(h), w);
  b.right.assign(static_cast<std::size_t>(h), -1);
  b.top.assign(static_cast<std::size_t>(w), h);
  b.bottom.assign(static_cast<std::size_t>(w), -1);

  const auto at = [&](int u, int v) {
    return cloud.seen(static_cast<std::size_t>(v) * static_cast<std::size_t>(w) +
                      static_cast<std::size_t>(u));
  };
  for (int v = 0; v < h; ++v) {
    const std::size_t i = static_cast<std::size_t>(v);
    for (int u = 0; u <= std::min(w - 1, kWidestSide) && b.left[i] == w; ++u)
      if (at(u, v)) b.left[i] = u;
    for (int u = w - 1; u >= std::max(0, w - 1 - kWidestSide) && b.right[i] < 0; --u)
      if (at(u, v)) b.right[i] = u;
  }
  for (int v = 0; v <= std::min(h - 1, kWidestEnd); ++v)
    for (int u = 0; u < w; ++u)
      if (b.top[static_cast<std::size_t>(u)] == h && at(u, v)) b.top[static_cast<std::size_t>(u)] = v;
  for (int v = h - 1; v >= std::max(0, h - 1 - kWidestEnd); --v)
    for (int u = 0; u < w; ++u)
      if (b.bottom[static_cast<std::size_t>(u)] < 0 && at(u, v)) b.bottom[static_cast<std::size_t>(u)] = v;

  settle(b.left, 0, kWidestSide, true);
  settle(b.right, w - 1, kWidestSide, false);
  settle(b.top, 0, kWidestEnd, true);
  settle(b.bottom, h - 1, kWidestEnd, false);
  return b;
}

}  // namespace colift::perception
