#pragma once

#include "sim_hal/synthetic/shapes.hpp"

namespace colift::sim_hal {

/// Where a part of a body is nearest to a solid.
struct Nearest {
  double distance_m = 0.0;        ///< Between the surfaces; negative: depth.
  double along = 0.0;             ///< On the part's axis, 0 to 1.
  Vec3 on_axis_W = Vec3::Zero();  ///< The point of the part's axis there.
};

/// Radius of a ball around a shape's middle that holds it (m); infinite for a half-space.
[[nodiscard]] double bounding_radius(const Shape& shape);

/// A part of a body as a capsule: a sphere is one without length, a box one along its longest edge, as thick
/// as its other two are on average.
[[nodiscard]] Shape as_capsule(const Shape& part);

/// Of a capsule and a convex solid, to 0.1 mm.
[[nodiscard]] Nearest nearest(const Shape& capsule, const Shape& solid);

/// Unit vector out of a solid at a point, from the gradient of its distance; up where there is none.
[[nodiscard]] Vec3 outward(const Shape& solid, const Vec3& p_W);

}  // namespace colift::sim_hal
