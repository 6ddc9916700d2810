#include "perception/target/regions/components.hpp"

#include <catch2/catch.hpp>
#include <cstdint>
#include <queue>
#include <vector>

namespace colift::perception {
namespace {

// the definition, pixel by pixel
std::vector<std::int32_t> flood(const std::vector<float>& depth, const std::vector<std::uint8_t>& mask, int w,
                                int h, const DepthJump& jump) {
  std::vector<std::int32_t> label(depth.size(), -1);
  std::int32_t next = 0;
  for (int start = 0; start < w * h; ++start) {
    if (!mask[static_cast<std::size_t>(start)] || label[static_cast<std::size_t>(start)] >= 0) continue;
    std::queue<int> open;
    open.push(start);
    label[static_cast<std::size_t>(start)] = next;
    while (!open.empty()) {
      const int i = open.front();
      open.pop();
      for (int dv = -1; dv <= 1; ++dv) {
        for (int du = -1; du <= 1; ++du) {
          const int u = i % w + du, v = i / w + dv;
          if (u < 0 || v < 0 || u >= w || v >= h) continue;
          const std::size_t k = static_cast<std::size_t>(v * w + u);
          if (!mask[k] || label[k] >= 0 || !jump.same_surface(depth[static_cast<std::size_t>(i)], depth[k]))
            continue;
          label[k] = next;
          open.push(v * w + u);
        }
      }
    }
    ++next;
  }
  return label;
}

std::uint32_t scramble(std::uint32_t x) {
  x ^= x >> 16;
  x *= 0x7feb352dU;
  x ^= x >> 15;
  x *= 0x846ca68bU;
  return x ^ (x >> 16);
}

}  // namespace

TEST_CASE("regions equal a flood fill on random images", "[components]") {
  for (std::uint32_t seed = 0; seed < 200; ++seed) {
    const int w = 5 + static_cast<int>(scramble(seed) % 40),
              h = 3 + static_cast<int>(scramble(seed + 999) % 30);
    std::vector<float> depth(static_cast<std::size_t>(w * h));
    std::vector<std::uint8_t> mask(depth.size());
    for (std::size_t i = 0; i < depth.size(); ++i) {
      const std::uint32_t r = scramble(static_cast<std::uint32_t>(i) * 7919u + seed * 104729u);
      depth[i] = 1.0f + 0.05f * static_cast<float>(r % 3);
      mask[i] = (r >> 8) % 100 < 40 + seed % 50 ? 1 : 0;
    }
    const DepthJump jump{0.06f, 0.001f};
    const Components c = connected_components(depth, mask, w, h, jump);
    CHECK(c.labels(w, h) == flood(depth, mask, w, h, jump));
    std::size_t total = 0;
    for (const std::uint32_t n : c.pixels) total += n;
    CHECK(total == static_cast<std::size_t>(std::count(mask.begin(), mask.end(), 1)));
  }
}

}  // namespace colift::perception
