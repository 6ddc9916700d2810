#include "planner/hand/leg_face.hpp"

#include <cmath>

namespace colift::planner {

Extent extent_of(const perception::Rectangle& r, const Vec3& direction) {
  const double middle = direction.dot(r.center);
  const double half =
      0.5 * (std::abs(direction.dot(r.u)) * r.size.x() + std::abs(direction.dot(r.v)) * r.size.y());
  return {middle - half, middle + half};
}

bool is_leg_face(const perception::Rectangle& face, const perception::Rectangle& plate, const SeenSpace& seen,
                 const LegFaceConfig& config) {
  const double step_m = config.step_m;
  const Vec3 along = plate.normal.cross(face.normal).normalized(), out = along.cross(plate.normal);
  const Extent leg = extent_of(face, along), edge = extent_of(plate, along);
  if (leg.length() > config.max_edge_fraction * edge.length()) return false;
  const double top = plate.normal.dot(plate.center), bottom = extent_of(face, plate.normal).low;
  const Vec3 level =
      (top + config.level_fraction * (bottom - top)) * plate.normal + out.dot(face.center) * out;
  int looked = 0, free = 0;
  for (double l = edge.low; l <= edge.high; l += step_m) {
    if (l > leg.low - step_m && l < leg.high + step_m) continue;
    ++looked;
    free += seen.at(level + l * along) == Sight::Free;
  }
  return free > config.min_free_fraction * looked;
}

}  // namespace colift::planner
