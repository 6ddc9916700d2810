#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <optional>
#include <vector>

#include "../figures.hpp"
#include "perception/motion/object_motion.hpp"
#include "sim_hal/synthetic/hash_random.hpp"
#include "sim_hal/synthetic/scenes.hpp"

namespace colift::perception::test {

using sim_hal::Label;
using sim_hal::ObjectKind;

inline double degrees(double rad) {
  return rad * 180.0 / std::numbers::pi;
}
inline double radians(double deg) {
  return deg * std::numbers::pi / 180.0;
}

/// A synthetic scene whose object can be moved while a partner holds it, seen by a noisy camera.
struct MovingObject {
  sim_hal::SyntheticScene scene;
  sim_hal::PartnerPose partner;
  ReferenceImage reference;
  Target target;
  std::uint64_t seed;

  MovingObject(ObjectKind kind, std::uint64_t s, int reference_frames = 10)
      : scene(sim_hal::make_scene(kind, s)), seed(s) {
    partner = sim_hal::make_partner(scene, seed, true);
    const auto truth = sim_hal::cast_rays(scene.world, scene.intrinsics, scene.X_WC);
    std::vector<hal::DepthFrame> frames;
    for (int i = 0; i < reference_frames; ++i)
      frames.push_back(sim_hal::measure(truth, {}, 1000 * seed + static_cast<std::uint64_t>(i)));
    reference = build_reference(frames, scene.X_WC, NoiseModel{}).value();
    for (std::uint32_t i = 0; i < truth.depth_m.size(); ++i) {
      if (truth.label[i] != Label::Target || !reference.cloud.seen(i)) continue;
      // at ragged edges a pixel may show the background
      if (std::abs(reference.cloud.depth_m[i] - truth.depth_m[i]) < 0.04F) target.pixels.push_back(i);
    }
  }

  [[nodiscard]] ObjectFollower follower() const {
    return ObjectFollower::make(reference, target, NoiseModel{}, MotionConfig{}).value();
  }

  /// The world with the object moved by X (a point p of it goes to X p), and the partner's hands with it.
  [[nodiscard]] sim_hal::World moved(const hal::Pose& X, bool with_partner = true) const {
    sim_hal::World world = scene.world;
    for (auto& shape : world.shapes)
      if (shape.label == Label::Target) shape.X_WS = X * shape.X_WS;
    if (!with_partner) return world;
    sim_hal::PartnerPose now = partner;
    now.contact = X * partner.contact;
    if (partner.second_contact) now.second_contact = X * *partner.second_contact;
    return sim_hal::with_partner(world, now);
  }

  [[nodiscard]] hal::DepthFrame see(const sim_hal::World& world, std::uint64_t frame) const {
    return sim_hal::measure(sim_hal::cast_rays(world, scene.intrinsics, scene.X_WC), {},
                            7919 * seed + 100003 * frame + 17);
  }

  /// Turn by `angle` about a horizontal axis through the centre of gravity, then shift.
  [[nodiscard]] hal::Pose motion(const hal::Vec3& axis, double angle_rad, const hal::Vec3& shift) const {
    hal::Pose X = hal::Pose::Identity();
    X.linear() = Eigen::AngleAxisd(angle_rad, axis).toRotationMatrix();
    X.translation() = scene.cog + shift - X.linear() * scene.cog;
    return X;
  }

  /// A horizontal axis about which a turn can be seen: any, but for a pipe the one across it.
  [[nodiscard]] hal::Vec3 tilt_axis() const {
    if (scene.kind == ObjectKind::Pipe)
      return scene.cylinders.front().axis.cross(hal::Vec3::UnitZ()).normalized();
    const double angle = 2 * std::numbers::pi * sim_hal::unit(sim_hal::hash(seed, 5, 0));
    return {std::cos(angle), std::sin(angle), 0.0};
  }

  /// Lift with tilt at part s (0 to 1) of the way: up to 6 cm up, 5 deg, and a little sideways.
  [[nodiscard]] hal::Pose lift(double s) const {
    const double rise = 0.03 + 0.03 * sim_hal::unit(sim_hal::hash(seed, 5, 1));
    const double tilt = radians(1.0 + 4.0 * sim_hal::unit(sim_hal::hash(seed, 5, 2)));
    const hal::Vec3 side = 0.01 * tilt_axis();
    return motion(tilt_axis(), s * tilt, s * (rise * hal::Vec3::UnitZ() + side));
  }
};

/// Errors of one frame against the truth.
struct MotionError {
  double rise_m, tilt_rad;
};
inline MotionError error_of(const ObjectMotion& seen, const hal::Pose& truth, const hal::Vec3& cog) {
  const hal::Vec3 up = hal::Vec3::UnitZ();
  // the tilt's error is the angle between the up axes, its magnitude alone would hide a wrong direction
  const hal::Vec3 a = seen.X_WTnow_WTref.linear() * up, b = truth.linear() * up;
  return {seen.rise(cog, up) - up.dot(truth * cog - cog), std::atan2(a.cross(b).norm(), a.dot(b))};
}

}  // namespace colift::perception::test
