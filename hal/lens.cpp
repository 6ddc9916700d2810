#include "hal/lens.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace colift::hal {
namespace {

// Four pixels lie on one surface when their depths differ by less than this fraction: a plane seen at 80
// degrees changes by 1 % over a pixel of a usual depth camera.
constexpr float kSameSurface = 0.02f;
constexpr int kMinSide = 16, kMaxSide = 4096;  // pixels
constexpr double kMinFocal_px = 10.0, kMaxFocal_px = 20000.0;

// What the lens does to a ray (x, y, 1), as OpenCV's rational model has it.
struct Terms {
  double radial;            // factor
  double aside_x, aside_y;  // tangential, added
};

Terms terms_at(const LensDistortion& lens, double x, double y) {
  const auto& [k1, k2, p1, p2, k3, k4, k5, k6] = lens;
  const double r2 = x * x + y * y;
  return {(1.0 + r2 * (k1 + r2 * (k2 + r2 * k3))) / (1.0 + r2 * (k4 + r2 * (k5 + r2 * k6))),
          2.0 * p1 * x * y + p2 * (r2 + 2.0 * x * x), p1 * (r2 + 2.0 * y * y) + 2.0 * p2 * x * y};
}

}  // namespace

std::string impossible(const CameraIntrinsics& k, const LensDistortion& lens) {
  if (k.width < kMinSide || k.width > kMaxSide || k.height < kMinSide || k.height > kMaxSide)
    return fmt::format("a size of {} x {} pixels; expected {} to {}", k.width, k.height, kMinSide, kMaxSide);
  if (!(k.fx > kMinFocal_px && k.fx < kMaxFocal_px && k.fy > kMinFocal_px && k.fy < kMaxFocal_px))
    return fmt::format("focal lengths {} and {} px; expected {} to {}", k.fx, k.fy, kMinFocal_px,
                       kMaxFocal_px);
  if (!(k.cx >= 0.0 && k.cx <= k.width && k.cy >= 0.0 && k.cy <= k.height))
    return fmt::format("the principal point ({}, {}) lies outside the image", k.cx, k.cy);
  if (!lens.none() && !lens.unique_within(k)) return "the distortion maps two rays to one pixel";
  return "";
}

bool LensDistortion::none() const {
  return k1 == 0 && k2 == 0 && p1 == 0 && p2 == 0 && k3 == 0 && k4 == 0 && k5 == 0 && k6 == 0;
}

std::array<double, 2> LensDistortion::distort(double x, double y) const {
  const Terms t = terms_at(*this, x, y);
  return {x * t.radial + t.aside_x, y * t.radial + t.aside_y};
}

std::array<double, 2> LensDistortion::undistort(double seen_x, double seen_y) const {
  double x = seen_x, y = seen_y;
  for (int i = 0; i < 20; ++i) {
    const Terms t = terms_at(*this, x, y);
    x = (seen_x - t.aside_x) / t.radial;
    y = (seen_y - t.aside_y) / t.radial;
  }
  return {x, y};
}

bool LensDistortion::unique_within(const CameraIntrinsics& c) const {
  constexpr int kSteps = 200;
  for (const double u : {0.0, 0.5 * c.width, c.width - 1.0}) {
    for (const double v : {0.0, 0.5 * c.height, c.height - 1.0}) {
      const double x = (u - c.cx) / c.fx, y = (v - c.cy) / c.fy, reach = std::hypot(x, y);
      if (reach < 1e-9) continue;
      double last = 0.0;
      for (int i = 1; i <= kSteps; ++i) {
        const double part = static_cast<double>(i) / kSteps;
        const auto [a, b] = distort(part * x, part * y);
        const double along = (a * x + b * y) / reach;
        if (!(along > last)) return false;  // folded, or not a number
        last = along;
      }
    }
  }
  return true;
}

std::vector<float> rectify(const std::vector<float>& depth_m, const CameraIntrinsics& c,
                           const LensDistortion& lens) {
  std::vector<float> out(depth_m.size(), std::numeric_limits<float>::quiet_NaN());
  const auto at = [&](int u, int v) {
    return depth_m[static_cast<std::size_t>(v) * static_cast<std::size_t>(c.width) +
                   static_cast<std::size_t>(u)];
  };
  for (int v = 0; v < c.height; ++v) {
    for (int u = 0; u < c.width; ++u) {
      const auto [x, y] = lens.distort((u - c.cx) / c.fx, (v - c.cy) / c.fy);
      const double su = c.fx * x + c.cx, sv = c.fy * y + c.cy;
      if (!(su > -0.5 && sv > -0.5 && su < c.width - 0.5 && sv < c.height - 0.5)) continue;
      float& depth =
          out[static_cast<std::size_t>(v) * static_cast<std::size_t>(c.width) + static_cast<std::size_t>(u)];
      depth = at(static_cast<int>(std::lround(su)), static_cast<int>(std::lround(sv)));
      const int u0 = static_cast<int>(std::floor(su)), v0 = static_cast<int>(std::floor(sv));
      if (u0 < 0 || v0 < 0 || u0 + 1 >= c.width || v0 + 1 >= c.height) continue;
      const float a = at(u0, v0), b = at(u0 + 1, v0), d = at(u0, v0 + 1), e = at(u0 + 1, v0 + 1);
      const auto [low, high] = std::minmax({a, b, d, e});
      if (!(high - low <= kSameSurface * low)) continue;  // one is missing, or they lie on two surfaces
      const auto s = static_cast<float>(su - u0), t = static_cast<float>(sv - v0);
      depth = (1 - t) * ((1 - s) * a + s * b) + t * ((1 - s) * d + s * e);
    }
  }
  return out;
}

}  // namespace colift::hal
