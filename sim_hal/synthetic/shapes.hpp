#pragma once

#include <cstdint>
#include <vector>

#include "hal/types/geometry.hpp"

namespace colift::hal {
struct LinkShape;
}

namespace colift::sim_hal {

using hal::Pose;
using hal::Vec3;

/// What a pixel shows, as truth for tests.
enum class Label : std::uint8_t { Nothing, Ground, Target, Partner, Clutter, Wall, Robot };

/// Which part of a person a shape is.
enum class BodyPart : std::uint8_t {
  None,
  Head,
  Neck,
  Shoulders,
  Trunk,
  UpperArm,
  LowerArm,
  Hand,
  Thigh,
  LowerLeg,
  Foot
};

/// A solid primitive in W. Sizes: box = full lengths x, y, z; cylinder and capsule = radius, length along Sz
/// (the capsule's length without its caps), unused; sphere = radius, unused, unused; half space = unused,
/// surface at Sz = 0, solid below.
struct Shape {
  enum class Kind : std::uint8_t { Box, Cylinder, Capsule, Sphere, HalfSpace };
  Kind kind = Kind::Box;
  Pose X_WS = Pose::Identity();
  Vec3 size = Vec3::Zero();
  Label label = Label::Clutter;
  double reflectivity =
      0.6;  ///< In the near infrared, 0 to 1; dark surfaces give no depth at grazing angles.
  BodyPart part = BodyPart::None;
  bool left = false;  ///< Of a person's parts that come in pairs.
};

/// All that a camera can see; what hides what follows from the shapes.
struct World {
  std::vector<Shape> shapes;
};

[[nodiscard]] Shape box(const Vec3& center, const Vec3& size, double yaw_rad, Label label);
[[nodiscard]] Shape cylinder(const Vec3& center, const Vec3& axis, double radius, double length, Label label);
[[nodiscard]] Shape capsule(const Vec3& from, const Vec3& to, double radius, Label label);
[[nodiscard]] Shape sphere(const Vec3& center, double radius, Label label);
[[nodiscard]] Shape half_space(const Vec3& point, const Vec3& normal, Label label);

/// A shape of a robot's link, whose frame L is at X_WL.
[[nodiscard]] Shape link_shape(const hal::LinkShape& shape, const Pose& X_WL);

/// Signed distance of a point in W to the surface of a shape (m), negative inside.
[[nodiscard]] double distance(const Shape& shape, const Vec3& p_W);

/// Distance of a point to the nearest shape with this label (m); infinite where there is none.
[[nodiscard]] double distance(const World& world, Label label, const Vec3& p_W);

}  // namespace colift::sim_hal
