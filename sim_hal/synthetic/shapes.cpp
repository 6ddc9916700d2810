#include "sim_hal/synthetic/shapes.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "hal/robot_model/robot_model.hpp"

namespace colift::sim_hal {
namespace {

// a frame whose third axis is given; the other two are any
Pose along(const Vec3& origin, const Vec3& axis) {
  const Vec3 n = axis.normalized();
  const auto [u, v] = hal::tangents(n);
  Pose X = Pose::Identity();
  X.linear() << u, v, n;
  X.translation() = origin;
  return X;
}

// distance to a body of which the excess over its half sizes is known along independent directions
double rounded(double excess_a, double excess_b, double excess_c) {
  const double outside =
      std::hypot(std::max(excess_a, 0.0), std::max(excess_b, 0.0), std::max(excess_c, 0.0));
  return outside + std::min(std::max({excess_a, excess_b, excess_c}), 0.0);
}

}  // namespace

Shape box(const Vec3& center, const Vec3& size, double yaw_rad, Label label) {
  Shape s;
  s.kind = Shape::Kind::Box;
  s.X_WS.linear() = Eigen::AngleAxisd(yaw_rad, Vec3::UnitZ()).toRotationMatrix();
  s.X_WS.translation() = center;
  s.size = size;
  s.label = label;
  return s;
}

Shape cylinder(const Vec3& center, const Vec3& axis, double radius, double length, Label label) {
  Shape s;
  s.kind = Shape::Kind::Cylinder;
  s.X_WS = along(center, axis);
  s.size = {radius, length, 0.0};
  s.label = label;
  return s;
}

Shape capsule(const Vec3& from, const Vec3& to, double radius, Label label) {
  const double length = (to - from).norm();
  Shape s;
  s.kind = Shape::Kind::Capsule;
  s.X_WS = along(0.5 * (from + to), length > 0.0 ? Vec3(to - from) : Vec3::UnitZ());
  s.size = {radius, length, 0.0};
  s.label = label;
  return s;
}

Shape sphere(const Vec3& center, double radius, Label label) {
  Shape s;
  s.kind = Shape::Kind::Sphere;
  s.X_WS.translation() = center;
  s.size = {radius, 0.0, 0.0};
  s.label = label;
  return s;
}

Shape half_space(const Vec3& point, const Vec3& normal, Label label) {
  Shape s;
  s.kind = Shape::Kind::HalfSpace;
  s.X_WS = along(point, normal);
  s.label = label;
  return s;
}

Shape link_shape(const hal::LinkShape& s, const Pose& X_WL) {
  Shape shape;
  shape.kind = s.kind == hal::LinkShape::Kind::Box        ? Shape::Kind::Box
               : s.kind == hal::LinkShape::Kind::Cylinder ? Shape::Kind::Cylinder
                                                          : Shape::Kind::Sphere;
  shape.X_WS = X_WL * s.X_LS;
  shape.size = s.size;
  shape.label = Label::Robot;
  return shape;
}

double distance(const Shape& shape, const Vec3& p_W) {
  const Vec3 p = shape.X_WS.linear().transpose() * (p_W - shape.X_WS.translation());
  switch (shape.kind) {
    case Shape::Kind::Box: {
      const Vec3 excess = p.cwiseAbs() - 0.5 * shape.size;
      return rounded(excess.x(), excess.y(), excess.z());
    }
    case Shape::Kind::Cylinder: {
      const double radial = std::hypot(p.x(), p.y()) - shape.size[0];
      return rounded(radial, std::abs(p.z()) - 0.5 * shape.size[1], -std::numeric_limits<double>::infinity());
    }
    case Shape::Kind::Capsule: {
      const double z = std::clamp(p.z(), -0.5 * shape.size[1], 0.5 * shape.size[1]);
      return (p - Vec3(0, 0, z)).norm() - shape.size[0];
    }
    case Shape::Kind::Sphere:
      return p.norm() - shape.size[0];
    case Shape::Kind::HalfSpace:
      return p.z();
  }
  return std::numeric_limits<double>::infinity();
}

double distance(const World& world, Label label, const Vec3& p_W) {
  double nearest = std::numeric_limits<double>::infinity();
  for (const Shape& shape : world.shapes)
    if (shape.label == label) nearest = std::min(nearest, distance(shape, p_W));
  return nearest;
}

}  // namespace colift::sim_hal
