#include "perception/self_filter_rows.hpp"

#include "hal/types/avx2.hpp"

// Comparisons are written so that a missing depth stays NaN and never hits.

namespace colift::perception::self_filter {

COLIFT_ALSO_AVX2 void margins(const float* __restrict depth_m, float m0, float m2, int n,
                              float* __restrict low, float* __restrict high) {
  for (int u = 0; u < n; ++u) {
    const float w = 1.0f / depth_m[u];
    const float margin = m0 * w * w + m2;
    low[u] = w - margin;
    high[u] = w + margin;
  }
}

COLIFT_ALSO_AVX2 void bound_above(const float* __restrict x, float start, float slope, std::size_t n,
                                  float* __restrict high) {
  for (std::size_t u = 0; u < n; ++u) {
    const float w = start + slope * x[u];
    high[u] = w < high[u] ? w : high[u];
  }
}

COLIFT_ALSO_AVX2 void bound_below(const float* __restrict x, float start, float slope, std::size_t n,
                                  float* __restrict low) {
  for (std::size_t u = 0; u < n; ++u) {
    const float w = start + slope * x[u];
    low[u] = w > low[u] ? w : low[u];
  }
}

COLIFT_ALSO_AVX2 void hit_between(const float* __restrict low, const float* __restrict high, std::size_t n,
                                  std::int32_t* __restrict hit) {
  for (std::size_t u = 0; u < n; ++u) hit[u] |= low[u] <= high[u] ? 1 : 0;
}

COLIFT_ALSO_AVX2 void hit_round(const float* __restrict x, const float* __restrict low,
                                const float* __restrict high, const RowOfRound& r, std::size_t n,
                                std::int32_t* __restrict hit) {
  const float m2 = r.m2, m1 = r.m1, m0 = r.m0, vertex0 = r.vertex0, vertex1 = r.vertex1, c = r.curvature;
  for (std::size_t u = 0; u < n; ++u) {
    const float vertex = vertex0 + vertex1 * x[u];
    float w = low[u] > vertex ? low[u] : vertex;
    w = high[u] < w ? high[u] : w;
    const float off = w - vertex;
    const float value = c * off * off + (m2 * x[u] + m1) * x[u] + m0;
    hit[u] |= (value <= 0.0f ? 1 : 0) & (low[u] <= high[u] ? 1 : 0);
  }
}

COLIFT_ALSO_AVX2 void narrow(const std::int32_t* __restrict from, int n, std::uint8_t* __restrict to) {
  for (int u = 0; u < n; ++u) to[u] = static_cast<std::uint8_t>(from[u]);
}

}  // namespace colift::perception::self_filter
