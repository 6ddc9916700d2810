#include "sim_hal/synthetic/kinect/kinect_edges.hpp"

#include <algorithm>
#include <cmath>

#include "sim_hal/synthetic/float4.hpp"

namespace colift::sim_hal {
namespace {

// f(k) for every place below n where two rows differ: nearly everywhere they are alike
template <class F>
void for_each_difference(const std::int16_t* a, const std::int16_t* b, int n, F f) {
  int k = 0;
  for (; k + 16 <= n; k += 16)
    for (std::uint32_t left = differing16(a + k, b + k); left != 0; left &= left - 1)
      f(k + std::countr_zero(left));
  for (; k < n; ++k)
    if (a[k] != b[k]) f(k);
}

}  // namespace

PixelSet::PixelSet(int width, int height)
    : width_(width),
      height_(height),
      words_((width + 63) / 64),
      bits_(static_cast<std::size_t>(words_ * height), 0) {}

PixelSet PixelSet::grown(int reach) const {
  PixelSet along(width_, height_), all(width_, height_);
  for (int v = 0; v < height_; ++v)
    for (int w = 0; w < words_; ++w) {
      const std::uint64_t here = row(v)[w];
      const std::uint64_t before = w > 0 ? row(v)[w - 1] : 0, after = w + 1 < words_ ? row(v)[w + 1] : 0;
      std::uint64_t wide = here;
      if ((here | before | after) != 0)
        for (int by = 1; by <= reach; ++by)
          wide |= here << by | here >> by | before >> (64 - by) | after << (64 - by);
      along.row(v)[w] = wide;
    }
  const int beyond = width_ % 64;  // bits of the last word that are no pixels
  if (beyond != 0)
    for (int v = 0; v < height_; ++v) along.row(v)[words_ - 1] &= (std::uint64_t{1} << beyond) - 1;
  for (int v = 0; v < height_; ++v)
    for (int y = std::max(v - reach, 0); y <= std::min(v + reach, height_ - 1); ++y)
      for (int w = 0; w < words_; ++w) all.row(v)[w] |= along.row(y)[w];
  return all;
}

std::size_t PixelSet::count() const {
  std::size_t all = 0;
  for (const std::uint64_t word : bits_) all += static_cast<std::size_t>(std::popcount(word));
  return all;
}

PixelSet find_edges(const Rendering& truth, float jump_m) {
  const int width = truth.intrinsics.width, height = truth.intrinsics.height;
  PixelSet edges(width, height);
  for (int v = 0; v < height; ++v) {
    const auto begin = static_cast<std::size_t>(v) * static_cast<std::size_t>(width);
    const std::int16_t* shape = truth.shape.data() + begin;
    const float* z = truth.depth_m.data() + begin;
    for_each_difference(shape, shape + 1, width - 1, [&](int u) {
      if (std::abs(z[u] - z[u + 1]) < jump_m) return;
      edges.insert(u, v);
      edges.insert(u + 1, v);
    });
    if (v + 1 == height) continue;
    for_each_difference(shape, shape + width, width, [&](int u) {
      if (std::abs(z[u] - z[u + width]) < jump_m) return;
      edges.insert(u, v);
      edges.insert(u, v + 1);
    });
  }
  return edges;
}

}  // namespace colift::sim_hal
