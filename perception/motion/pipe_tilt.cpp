#include "perception/motion/pipe_tilt.hpp"

#include <algorithm>
#include <cmath>
#include <variant>

namespace colift::perception {

std::optional<Vec3> pipe_axis(const Scene& scene) {
  constexpr double kSame_m = 1e-3;
  if (!scene.target) return std::nullopt;
  const Vec3& size = scene.target->shape.size;
  for (const Surface& s : scene.surfaces) {
    const auto* c = std::get_if<Cylinder>(&s);
    if (c != nullptr && std::abs(size.maxCoeff() - c->length) < kSame_m &&
        std::abs(size.minCoeff() - 2.0 * c->radius) < kSame_m)
      return c->axis.normalized();
  }
  return std::nullopt;
}

double slope_change(const hal::Pose& X_WTnow_WTref, const Vec3& axis, const Vec3& up) {
  const auto slope = [&](const Vec3& d) { return std::asin(std::clamp(d.dot(up), -1.0, 1.0)); };
  return std::abs(slope(X_WTnow_WTref.linear() * axis) - slope(axis));
}

}  // namespace colift::perception
