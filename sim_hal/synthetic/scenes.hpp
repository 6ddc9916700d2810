#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "hal/depth_camera.hpp"
#include "sim_hal/synthetic/kinect/kinect_noise.hpp"
#include "sim_hal/synthetic/ray_caster.hpp"
#include "sim_hal/synthetic/shapes.hpp"

namespace colift::sim_hal {

enum class ObjectKind { Table, Box, OpenBox, Pipe, Chair };

/// A planar face of the target as built: outward normal, full lengths along u and v.
struct TrueFace {
  Vec3 center, normal, u, v;
  double width, height;
};
/// A cylinder of the target as built (W, m).
struct TrueCylinder {
  Vec3 center, axis;
  double radius, length;
};

/// A world with an object on the floor z = 0, a fixed camera, and what is true about both (frame W, SI
/// units).
struct SyntheticScene {
  std::string name;
  ObjectKind kind = ObjectKind::Table;
  World world;  ///< Without the partner.
  hal::CameraIntrinsics intrinsics;
  Pose X_WC = Pose::Identity();
  hal::Plane ground{Vec3::UnitZ(), 0.0};
  Vec3 cog = Vec3::Zero();  ///< Centre of gravity at uniform density.
  std::vector<TrueFace> faces;
  std::vector<TrueCylinder> cylinders;
  std::vector<Vec3> graspable;  ///< Points on the rim where a person would take hold.
};

/// A scene of the given kind, drawn from a seed: size, pose, camera (1.2 to 2.2 m away, 25 to 50 degrees
/// down), 0 to 4 pieces of clutter, in some rooms a wall. The whole object is in view; clutter stands clear
/// of it by 15 cm, but for a "pipe on blocks" (about one pipe in four; it is in the name), which lies on two
/// of them.
[[nodiscard]] SyntheticScene make_scene(ObjectKind kind, std::uint64_t seed);

/// How a partner stands and reaches.
struct PartnerPose {
  Vec3 contact = Vec3::Zero();         ///< Where the palm holds the object.
  Vec3 from = Vec3::Zero();            ///< Shoulder, from which the arm reaches.
  std::optional<Vec3> second_contact;  ///< The other hand, when both are used.
};

/// The world with a person who stands near the object and touches nothing: behind it as the camera sees it,
/// or before it, partly in the camera's way.
[[nodiscard]] World with_passer_by(const SyntheticScene& scene, std::uint64_t seed, bool in_front);

/// The world with a partner: body, head, one or two arms and hands; the hand touches the object at `contact`.
[[nodiscard]] World with_partner(const World& world, const PartnerPose& partner);

/// A plausible partner for a scene, drawn from a seed: contact on a graspable point that the camera sees. Two
/// hands where the object has room for them, else one.
[[nodiscard]] PartnerPose make_partner(const SyntheticScene& scene, std::uint64_t seed, bool two_hands);

}  // namespace colift::sim_hal
