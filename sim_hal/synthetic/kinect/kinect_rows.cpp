#include "sim_hal/synthetic/kinect/kinect_rows.hpp"

#include <bit>
#include <limits>

#include "hal/types/avx2.hpp"
#include "sim_hal/synthetic/kinect/kinect_code.hpp"

namespace colift::sim_hal::kinect_rows {
namespace {

// measured on planes in single frames of real sensors: the total, quantisation included
constexpr float kSigma0_m = 0.0003f, kSigma2_per_m = 0.0012f;
constexpr auto kCode_m = static_cast<float>(kKinectK_mm / 1000.0);  // k in raw = raw at infinity - k / z

/// Square root of a positive number, up to 0.2 % too small: one step of Newton's from a first guess that
/// comes from halving the exponent (Lomont, Fast inverse square root, 2003). The same bits on every machine.
inline float rough_sqrt(float a) {
  const float guess = std::bit_cast<float>(0x5f375a86U - (std::bit_cast<std::uint32_t>(a) >> 1));
  return a * guess * (1.5f - 0.5f * a * guess * guess);
}

// theta^2 / (pi/2 - theta)^2 times 0.1 mm sqrt(m) / sqrt(z), the growth of axial noise at grazing angles
// (Nguyen, Izadi, Lovell 2012), without its last factor. The parabola is a fit of cos^2 / (1 - cos) theta^2 /
// (pi/2 - theta)^2, good to 1.3 % beyond 32 degrees; before, to 0.7 um.
inline float grazing_sigma(float c) {
  const float fit = 2.4604e-4f - (0.5635e-4f + 0.7301e-4f * c) * c;
  return (1.0f - c) * fit / (c * c);
}

// Limits are kept in loops of their own: where one stands beside arithmetic the compiler makes two branches.
constexpr std::size_t kBlock = 64;

}  // namespace

COLIFT_ALSO_AVX2 void invert(const float* __restrict from, std::size_t n, float* __restrict to) {
  for (std::size_t u = 0; u < n; ++u) to[u] = 1.0f / from[u];
}

// a depth error e at z is one of e / z^2 of 1 / z; rounding to codes adds its own twelfth of a step squared,
// and the sum is what was measured
COLIFT_ALSO_AVX2 void shake(const std::int16_t* __restrict grain, float grain_unit,
                            const float* __restrict cosine, bool rounded, std::size_t n,
                            float* __restrict inverse_depth) {
  const float rounding2 = rounded ? 1.0f / (12.0f * kCode_m * kCode_m) : 0.0f;
  float c[kBlock];
  for (std::size_t begin = 0; begin < n; begin += kBlock) {
    const std::size_t size = n - begin < kBlock ? n - begin : kBlock;
    for (std::size_t u = 0; u < size; ++u) c[u] = cosine[begin + u] > 0.02f ? cosine[begin + u] : 0.02f;
    for (std::size_t u = 0; u < size; ++u) {
      const float w = inverse_depth[begin + u];
      const float sigma = (kSigma0_m + grazing_sigma(c[u]) * rough_sqrt(w)) * w * w + kSigma2_per_m;
      const float own = rough_sqrt(sigma * sigma - rounding2);
      inverse_depth[begin + u] = w + static_cast<float>(grain[begin + u]) * grain_unit * own;
    }
  }
}

COLIFT_ALSO_AVX2 void read_codes(const float* __restrict inverse_depth, std::size_t n,
                                 float* __restrict depth_m) {
  constexpr auto kLast = static_cast<float>(kKinectCodes + 1);
  constexpr auto kAtInfinity = static_cast<float>(kKinectRawAtInfinity + 1.5);  // a half to round, one up
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
  // kKinectK_mm and the fractional part of kKinectRawAtInfinity, rounded so that every code has its depth to the
  // bit
  constexpr float kK_mm = 345489.375F, kBeyond = 0.408F;
  float raw[kBlock];
  std::int32_t mm[kBlock];
  for (std::size_t begin = 0; begin < n; begin += kBlock) {
    const std::size_t size = n - begin < kBlock ? n - begin : kBlock;
    for (std::size_t u = 0; u < size; ++u) raw[u] = kAtInfinity - kCode_m * inverse_depth[begin + u];
    for (std::size_t u = 0; u < size; ++u) raw[u] = raw[u] > 0.0F ? raw[u] : 0.0F;  // of what has no depth
    for (std::size_t u = 0; u < size; ++u) raw[u] = raw[u] < kLast ? raw[u] : kLast;
    for (std::size_t u = 0; u < size; ++u) raw[u] = static_cast<float>(static_cast<std::int32_t>(raw[u]));
    for (std::size_t u = 0; u < size; ++u)
      mm[u] = static_cast<std::int32_t>(kK_mm / (kLast - raw[u] + kBeyond));
    for (std::size_t u = 0; u < size; ++u) depth_m[begin + u] = static_cast<float>(mm[u]) / 1000.0F;
    for (std::size_t u = 0; u < size; ++u) depth_m[begin + u] = raw[u] > 0.0F ? depth_m[begin + u] : kNan;
    for (std::size_t u = 0; u < size; ++u) depth_m[begin + u] = raw[u] < kLast ? depth_m[begin + u] : kNan;
  }
}

COLIFT_ALSO_AVX2 bool all_seen(const Light& light, const float* __restrict inverse_depth,
                               const float* __restrict cosine, std::size_t n) {
  const float nearest = light.nearest, farthest = light.farthest, reflectivity = light.reflectivity,
              bright = light.bright, facing = light.facing;
  std::int32_t seen = 1;
  float near[kBlock];
  for (std::size_t u = 0; u < n; ++u) near[u] = inverse_depth[u] < 1.0f ? inverse_depth[u] : 1.0f;
  for (std::size_t u = 0; u < n; ++u) {
    const float w = inverse_depth[u];
    const float back = reflectivity * cosine[u] * near[u] * near[u];
    seen &= static_cast<std::int32_t>(nearest > w) & static_cast<std::int32_t>(w > farthest) &
            static_cast<std::int32_t>(back > bright) & static_cast<std::int32_t>(cosine[u] > facing);
  }
  return seen != 0;
}

COLIFT_ALSO_AVX2 void disparities(const float* __restrict inverse_depth, const float* __restrict columns,
                                  float shift, float most, float middle, std::size_t n,
                                  float* __restrict disparity, std::int32_t* __restrict column) {
  for (std::size_t u = 0; u < n; ++u) disparity[u] = most > inverse_depth[u] ? inverse_depth[u] : 0.0f;
  for (std::size_t u = 0; u < n; ++u) {
    disparity[u] *= shift;
    column[u] = static_cast<std::int32_t>(columns[u] + middle - disparity[u]);
  }
}

}  // namespace colift::sim_hal::kinect_rows
