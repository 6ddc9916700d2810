#include "planner/hand/seen_space.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace colift::planner {

SeenSpace::SeenSpace(const perception::OrganisedCloud& cloud, const perception::NoiseModel& noise,
                     double sigmas, int max_gap_px)
    : intrinsics_(cloud.intrinsics),
      X_CW_(cloud.X_WC.inverse()),
      camera_(cloud.X_WC.translation()),
      noise_(noise),
      sigmas_(sigmas),
      depth_m_(cloud.depth_m),
      fx_(static_cast<float>(intrinsics_.fx)),
      fy_(static_cast<float>(intrinsics_.fy)),
      cx_(static_cast<float>(intrinsics_.cx + 0.5)),
      cy_(static_cast<float>(intrinsics_.cy + 0.5)) {
  for (int v = 0; v < intrinsics_.height; ++v) {
    float* row = depth_m_.data() + static_cast<std::ptrdiff_t>(v) * intrinsics_.width;
    const int width = intrinsics_.width;
    const auto missing = [&](int u) { return !(row[u] == row[u]); };
    int u = 0;
    while (u < width && missing(u)) ++u;
    while (u < width) {
      while (u < width && !missing(u)) ++u;
      const int first = u;
      while (u < width && missing(u)) ++u;
      if (u < width && u - first <= max_gap_px) {
        std::fill(row + first, row + u, std::min(row[first - 1], row[u]));
      }
    }
  }
}

double SeenSpace::measured(const Vec3& p) const {
  constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();
  if (p.z() <= 0.0) return kUnknown;
  const double scale = 1.0 / p.z();
  const double u = intrinsics_.fx * p.x() * scale + intrinsics_.cx + 0.5;
  const double v = intrinsics_.fy * p.y() * scale + intrinsics_.cy + 0.5;
  if (!(u >= 0.0 && v >= 0.0 && u < intrinsics_.width && v < intrinsics_.height)) return kUnknown;
  return depth_m_[static_cast<std::size_t>(static_cast<int>(v) * intrinsics_.width + static_cast<int>(u))];
}

double SeenSpace::clearance(const Vec3& p_W) const {
  const Vec3 p = X_CW_ * p_W;
  return measured(p) - p.z();
}

Sight SeenSpace::sight(const Vec3& p) const {
  const double depth = measured(p);
  if (!(depth == depth)) return Sight::Unknown;
  const double clear = depth - p.z();
  const double tolerance = sigmas_ * noise_.sigma(depth) + noise_.step(depth);
  if (clear > tolerance) return Sight::Free;
  return clear < -tolerance ? Sight::Hidden : Sight::Surface;
}

}  // namespace colift::planner
