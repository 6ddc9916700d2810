#include "perception/change_limit.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace colift::perception {
namespace {

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
constexpr float kFar = std::numeric_limits<float>::max();

// Noise is not squared beyond this, to stay finite (m).
constexpr float kFarSide = 100.0F;

// Depth that a pixel without reference must stay before. A hole inside a surface (dark spot, grazing light)
// gets the nearer of its two sides in the row. The projector's shadow beside an edge gets the farther one: a
// hand may well come out there behind the object. Nothing on either side: whatever appears is new.
void fill_row(const float* near, float* filled, int width, float shadow_step) {
  int u = 0;
  while (u < width) {
    if (near[u] == near[u]) {
      filled[u] = near[u];
      ++u;
      continue;
    }
    int end = u;
    while (end < width && near[end] != near[end]) ++end;
    const float left = u > 0 ? near[u - 1] : kFar;
    const float right = end < width ? near[end] : kFar;
    float fill = std::min(left, right);
    if (left < kFar && right < kFar && std::abs(left - right) > shadow_step) fill = std::max(left, right);
    std::fill(filled + u, filled + end, fill);
    u = end;
  }
}

}  // namespace

ChangeMargin::ChangeMargin(const NoiseModel& noise, const ChangeConfig& config)
    : constant_m(static_cast<float>(config.sigmas * noise.sigma0_m + config.margin_m)),
      per_m(static_cast<float>(config.sigmas * noise.sigma2_per_m + config.steps * noise.step2_per_m)) {}

std::vector<float> change_limits(const ReferenceImage& reference, const NoiseModel& noise,
                                 const ChangeConfig& config, const PixelWindow& window) {
  std::vector<float> limits(reference.near_m.size(), kNan);
  if (window.empty()) return limits;
  const int row_px = reference.cloud.width(), height = reference.cloud.height();
  const auto width = static_cast<std::size_t>(row_px);

  // smallest depth within edge_px: down the columns, then along the row, in padded buffers
  const int edge = config.edge_px;
  const auto pad = static_cast<std::size_t>(edge);
  const int top = std::max(0, window.v_begin - edge), bottom = std::min(height, window.v_end + edge);
  std::vector<float> filled(width * static_cast<std::size_t>(bottom - top));
  for (int v = top; v < bottom; ++v) {
    fill_row(reference.near_m.data() + static_cast<std::size_t>(v) * width,
             filled.data() + static_cast<std::size_t>(v - top) * width, row_px,
             static_cast<float>(config.shadow_step_m));
  }
  std::vector<float> down(width + 2 * pad, kFar), nearest(width);
  const ChangeMargin margin(noise, config);
  const auto slope0 = static_cast<float>(config.edge_step_m + 4.0 * noise.sigma0_m);
  const auto slope2 = static_cast<float>(4.0 * noise.sigma2_per_m);
  for (int v = window.v_begin; v < window.v_end; ++v) {
    std::fill(down.begin(), down.end(), kFar);
    float* low = down.data() + pad;
    for (int k = std::max(top, v - edge); k <= std::min(bottom - 1, v + edge); ++k) {
      const float* from = filled.data() + static_cast<std::size_t>(k - top) * width;
      for (std::size_t u = 0; u < width; ++u) low[u] = from[u] < low[u] ? from[u] : low[u];
    }
    std::fill(nearest.begin(), nearest.end(), kFar);
    for (std::size_t k = 0; k <= 2 * pad; ++k) {
      const float* from = down.data() + k;
      for (std::size_t u = 0; u < width; ++u) nearest[u] = from[u] < nearest[u] ? from[u] : nearest[u];
    }
    const std::size_t row = static_cast<std::size_t>(v) * width;
    const float* typical = reference.cloud.depth_m.data() + row;
    float* limit = limits.data() + row;
    for (auto u = static_cast<std::size_t>(window.u_begin); u < static_cast<std::size_t>(window.u_end); ++u) {
      // away from edges the typical depth is the sharper standard: fingers on a surface stand out by less
      // than 2 cm; a NaN compares false
      const float z = nearest[u], squared = std::min(z, kFarSide) * std::min(z, kFarSide);
      const float standard = typical[u] - z < slope0 + slope2 * squared ? typical[u] : z;
      // noise at a missing background is nobody's: any depth that appears there is new
      limit[u] = z >= kFar ? kFar : standard - margin.of_squared(squared);
    }
  }
  return limits;
}

}  // namespace colift::perception
