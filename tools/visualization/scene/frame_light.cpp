#include "tools/visualization/scene/frame_light.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace colift::picture {
namespace {

constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();

std::vector<float> inverse_depth(const perception::OrganisedCloud& cloud) {
  std::vector<float> q(cloud.size(), kNaN);
  for (std::size_t i = 0; i < q.size(); ++i)
    if (cloud.seen(i) && cloud.depth_m[i] > 0.0f) q[i] = 1.0f / cloud.depth_m[i];
  return q;
}

// Brightness of the plane through the neighbours of one pixel that lie on its surface.
float lit(const std::vector<float>& q, const hal::CameraIntrinsics& k, int u, int v, int radius) {
  const float q0 = q[static_cast<std::size_t>(v * k.width + u)];
  const float jump = 0.008f + 0.02f * q0;
  float n = 0, su = 0, sv = 0, suu = 0, suv = 0, svv = 0, sq = 0, suq = 0, svq = 0;
  for (int dv = std::max(-radius, -v); dv <= std::min(radius, k.height - 1 - v); ++dv) {
    const float* row = q.data() + static_cast<std::ptrdiff_t>((v + dv) * k.width + u);
    for (int du = std::max(-radius, -u); du <= std::min(radius, k.width - 1 - u); ++du) {
      const float d = row[du] - q0;
      if (!(std::abs(d) < jump)) continue;
      const auto x = static_cast<float>(du), y = static_cast<float>(dv);
      n += 1, su += x, sv += y, suu += x * x, suv += x * y, svv += y * y, sq += d, suq += x * d, svq += y * d;
    }
  }
  const float uu = n * suu - su * su, vv = n * svv - sv * sv, uv = n * suv - su * sv;
  const float uq = n * suq - su * sq, vq = n * svq - sv * sq, det = uu * vv - uv * uv;
  const double rx = (u - k.cx) / k.fx, ry = (v - k.cy) / k.fy;
  hal::Vec3 normal(-rx, -ry, -1.0);
  if (n >= 4 && det > 0.01f * n * n) {
    const double a = (uq * vv - vq * uv) / det * k.fx, b = (vq * uu - uq * uv) / det * k.fy;
    normal = -hal::Vec3(a, b, static_cast<double>(q0) - a * rx - b * ry);
    if (normal.dot(hal::Vec3(rx, ry, 1.0)) > 0) normal = -normal;
  }
  normal.normalize();
  static const hal::Vec3 key = hal::Vec3(-0.45, -0.75, -0.65).normalized();
  const double facing = -normal.dot(hal::Vec3(rx, ry, 1.0).normalized());
  return static_cast<float>(0.34 + 0.48 * std::max(0.0, normal.dot(key)) + 0.2 * facing);
}

// Mean over a square around every pixel, of what was seen there.
std::vector<float> blurred(const std::vector<float>& q, int width, int height, int radius) {
  const auto w = static_cast<std::size_t>(width) + 1;
  std::vector<double> sum(w * (static_cast<std::size_t>(height) + 1), 0.0), count(sum.size(), 0.0);
  for (int v = 0; v < height; ++v)
    for (int u = 0; u < width; ++u) {
      const float value = q[static_cast<std::size_t>(v * width + u)];
      const bool seen = value == value;
      const std::size_t at = static_cast<std::size_t>(v + 1) * w + static_cast<std::size_t>(u + 1);
      sum[at] = sum[at - 1] + sum[at - w] - sum[at - w - 1] + (seen ? static_cast<double>(value) : 0.0);
      count[at] = count[at - 1] + count[at - w] - count[at - w - 1] + (seen ? 1.0 : 0.0);
    }
  std::vector<float> mean(q.size());
  for (int v = 0; v < height; ++v)
    for (int u = 0; u < width; ++u) {
      const auto top = static_cast<std::size_t>(std::max(0, v - radius)) * w;
      const auto bottom = static_cast<std::size_t>(std::min(height, v + radius + 1)) * w;
      const auto left = static_cast<std::size_t>(std::max(0, u - radius));
      const auto right = static_cast<std::size_t>(std::min(width, u + radius + 1));
      const auto box = [&](const std::vector<double>& s) {
        return s[bottom + right] - s[bottom + left] - s[top + right] + s[top + left];
      };
      mean[static_cast<std::size_t>(v * width + u)] =
          static_cast<float>(box(sum) / std::max(1.0, box(count)));
    }
  return mean;
}

}  // namespace

std::vector<float> light_of(const perception::OrganisedCloud& cloud) {
  const hal::CameraIntrinsics& k = cloud.intrinsics;
  const std::vector<float> q = inverse_depth(cloud);
  const std::vector<float> near = blurred(q, k.width, k.height, std::max(2, k.width / 50));
  const int radius = std::clamp(k.width / 160, 1, 4);
  std::vector<float> light(q.size(), kNaN);
  for (int v = 0; v < k.height; ++v)
    for (int u = 0; u < k.width; ++u) {
      const auto i = static_cast<std::size_t>(v * k.width + u);
      if (!(q[i] == q[i])) continue;
      // after Luft, Colditz and Deussen, "Image enhancement by unsharp masking the depth buffer" (2006)
      const float behind = std::clamp((near[i] - q[i]) / (0.5f * q[i]), 0.0f, 1.0f);
      light[i] = lit(q, k, u, v, radius) * (1.0f - 0.45f * behind);
    }
  return light;
}

}  // namespace colift::picture
