#include "sim_hal/people/touch.hpp"

#include <cmath>
#include <limits>
#include <numbers>

namespace colift::sim_hal {

double bounding_radius(const Shape& shape) {
  switch (shape.kind) {
    case Shape::Kind::Box:
      return 0.5 * shape.size.norm();
    case Shape::Kind::Cylinder:
      return std::hypot(shape.size[0], 0.5 * shape.size[1]);
    case Shape::Kind::Capsule:
      return shape.size[0] + 0.5 * shape.size[1];
    case Shape::Kind::Sphere:
      return shape.size[0];
    case Shape::Kind::HalfSpace:
      break;
  }
  return std::numeric_limits<double>::infinity();
}

Shape as_capsule(const Shape& part) {
  if (part.kind == Shape::Kind::Capsule) return part;
  Shape out = part;
  out.kind = Shape::Kind::Capsule;
  if (part.kind == Shape::Kind::Sphere) {
    out.size = {part.size[0], 0.0, 0.0};
    return out;
  }
  int longest = 0;
  const double length = part.size.maxCoeff(&longest);
  const double radius = 0.25 * (part.size.sum() - length);
  const Eigen::Matrix3d& R = part.X_WS.linear();
  const int u = (longest + 1) % 3, v = (longest + 2) % 3;
  out.X_WS.linear() << R.col(u), R.col(v), R.col(longest);
  out.size = {radius, std::max(length - 2.0 * radius, 0.0), 0.0};
  return out;
}

Nearest nearest(const Shape& capsule, const Shape& solid) {
  const Vec3 middle = capsule.X_WS.translation();
  const Vec3 axis = capsule.X_WS.linear().col(2);
  const double half = 0.5 * capsule.size[1];
  const auto at = [&](double s) { return distance(solid, middle + s * axis); };
  // the distance to a convex solid is convex along a line: golden section
  constexpr double kGolden = 1.0 / std::numbers::phi, kFine_m = 1e-4;
  double low = -half, high = half, s = 0.0;
  if (half > 0.0) {
    double a = high - kGolden * (high - low), b = low + kGolden * (high - low);
    double da = at(a), db = at(b);
    while (high - low > kFine_m) {
      if (da < db) {
        high = b, b = a, db = da;
        a = high - kGolden * (high - low), da = at(a);
      } else {
        low = a, a = b, da = db;
        b = low + kGolden * (high - low), db = at(b);
      }
    }
    s = 0.5 * (low + high);
  }
  Nearest out;
  out.on_axis_W = middle + s * axis;
  out.distance_m = distance(solid, out.on_axis_W) - capsule.size[0];
  out.along = half > 0.0 ? 0.5 + 0.5 * s / half : 0.5;
  return out;
}

Vec3 outward(const Shape& solid, const Vec3& p_W) {
  constexpr double kStep_m = 1e-5;
  Vec3 gradient;
  for (int i = 0; i < 3; ++i) {
    const Vec3 step = kStep_m * Vec3::Unit(i);
    gradient[i] = distance(solid, p_W + step) - distance(solid, p_W - step);
  }
  return gradient.norm() > 1e-9 ? gradient.normalized() : Vec3(Vec3::UnitZ());
}

}  // namespace colift::sim_hal
