#pragma once

#include <Eigen/Core>
#include <limits>
#include <vector>

#include "tools/visualization/scene/solid_scene.hpp"

namespace colift::picture {

using Vec3f = Eigen::Vector3f;

/// A solid made ready for rays.
struct RaySolid {
  Solid::Kind kind = Solid::Kind::Box;
  Eigen::Matrix3f R_SW = Eigen::Matrix3f::Identity();
  Vec3f origin = Vec3f::Zero();  ///< Of S in W.
  Vec3f size = Vec3f::Zero();    ///< Box: half lengths. Else radius and half length.
  Vec3f middle = Vec3f::Zero();  ///< Of a ball that holds it.
  float reach = 0.0f;            ///< Radius of that ball; infinite for the ground.
};

[[nodiscard]] RaySolid ray_solid(const Solid& solid);

/// Distance along a ray with unit direction to the first surface beyond 0 and before `before`; `before`
/// itself where there is none. With `normal`, the outward unit normal there (W).
[[nodiscard]] float cast(const RaySolid& solid, const Vec3f& from, const Vec3f& along, float before,
                         Vec3f* normal);

/// A bundle of rays: a ball that sweeps along an axis while it grows.
struct Bundle {
  Vec3f from, along;
  float radius = 0.0f;  ///< At its start (m).
  float spread = 0.0f;  ///< Growth for each metre.
  float length = std::numeric_limits<float>::infinity();
};

/// Whether a ray of the bundle may meet the solid.
[[nodiscard]] bool may_meet(const Bundle& bundle, const RaySolid& solid);

}  // namespace colift::picture
