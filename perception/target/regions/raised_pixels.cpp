#include "perception/target/regions/raised_pixels.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>

namespace colift::perception {
namespace {

// 1 where pixels a[i] and b[i] are both in the mask and on one surface
void link(const float* a, const float* b, const std::uint8_t* in_a, const std::uint8_t* in_b,
          const DepthJump& jump, int count, std::uint8_t* out) {
  const float base = jump.base_m, growth = jump.growth_per_m;
  for (int i = 0; i < count; ++i) {
    const float near = a[i] < b[i] ? a[i] : b[i];
    const std::uint8_t same = std::abs(a[i] - b[i]) <= base + growth * near * near ? 1 : 0;
    out[i] = static_cast<std::uint8_t>(same & in_a[i] & in_b[i]);
  }
}

}  // namespace

std::vector<std::uint8_t> raised_pixels(const OrganisedCloud& cloud, const Ground& ground,
                                        const NoiseModel& noise, const Clearance& clearance) {
  const Eigen::Vector3f n = ground.plane.normal.cast<float>();
  const float offset = static_cast<float>(ground.plane.offset);
  const float eye_height = static_cast<float>(std::max(1e-3, ground.plane.height(cloud.X_WC.translation())));
  const float base = static_cast<float>(clearance.base_m);
  const float k0 = static_cast<float>(clearance.sigma_factor * noise.sigma0_m);
  const float k2 = static_cast<float>(clearance.sigma_factor * noise.sigma2_per_m);
  std::vector<std::uint8_t> mask(cloud.size());
  const Eigen::Index w = cloud.width();
  Eigen::ArrayXf above(w);
  using Row = Eigen::Map<const Eigen::ArrayXf>;
  for (std::size_t row = 0; row < cloud.size(); row += static_cast<std::size_t>(w)) {
    const Row d(cloud.depth_m.data() + row, w), x(cloud.x.data() + row, w), y(cloud.y.data() + row, w),
        z(cloud.z.data() + row, w);
    // depth noise enters the height by the slope of the ray, at most one
    above = (n.x() * x + n.y() * y + n.z() * z + offset) -
            (base + (k0 + k2 * d * d) * (eye_height / d).min(1.0f));
    std::uint8_t* out = mask.data() + row;
    const float* a = above.data();
    for (Eigen::Index u = 0; u < w; ++u) out[u] = a[u] > 0.0f ? 1 : 0;
  }
  return mask;
}

void clear_flying_pixels(const OrganisedCloud& cloud, const DepthJump& jump, int min_neighbours,
                         std::vector<std::uint8_t>& mask) {
  const int w = cloud.width(), h = cloud.height();
  const std::size_t stride = static_cast<std::size_t>(w);
  // Links between a row and the one below, one column of margin on both sides: straight down, down right,
  // down left. Each serves both of its rows; `above` is the row before.
  using Row = std::vector<std::uint8_t>;
  Row down(stride + 2), right_down(stride + 2), left_down(stride + 2), beside(stride + 2);
  Row down_above = down, right_down_above = down, left_down_above = down;
  Row before(stride);
  for (int v = 0; v < h; ++v) {
    const float* d = cloud.depth_m.data() + static_cast<std::size_t>(v) * stride;
    std::uint8_t* m = mask.data() + static_cast<std::size_t>(v) * stride;
    if (!std::memchr(m, 1, stride)) {
      for (Row* row : {&down_above, &right_down_above, &left_down_above})
        std::fill(row->begin(), row->end(), std::uint8_t{0});
      continue;
    }
    std::copy_n(m, w, before.begin());
    const std::uint8_t* b = before.data();
    link(d, d + 1, b, b + 1, jump, w - 1, beside.data() + 1);
    if (v + 1 < h) {
      const std::uint8_t* next = m + stride;
      link(d, d + stride, b, next, jump, w, down.data() + 1);
      link(d, d + stride + 1, b, next + 1, jump, w - 1, right_down.data() + 1);
      link(d + 1, d + stride, b + 1, next, jump, w - 1, left_down.data() + 2);
    } else {
      for (Row* row : {&down, &right_down, &left_down}) std::fill(row->begin(), row->end(), std::uint8_t{0});
    }
    const std::uint8_t *s = beside.data(), *n = down.data(), *se = right_down.data(), *sw = left_down.data(),
                       *na = down_above.data(), *nw = right_down_above.data(), *ne = left_down_above.data();
    for (int u = 0; u < w; ++u) {
      const int neighbours =
          s[u] + s[u + 1] + n[u + 1] + se[u + 1] + sw[u + 1] + na[u + 1] + nw[u] + ne[u + 2];
      m[u] = static_cast<std::uint8_t>(b[u] & (neighbours >= min_neighbours ? 1 : 0));
    }
    down.swap(down_above);
    right_down.swap(right_down_above);
    left_down.swap(left_down_above);
  }
}

}  // namespace colift::perception
