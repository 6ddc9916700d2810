#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "hal/depth_camera.hpp"
#include "hal/robot_model/robot_model.hpp"
#include "hal/types/geometry.hpp"
#include "sim_hal/synthetic/shapes.hpp"
#include "tools/visualization/canvas.hpp"

namespace colift::picture {

using hal::Pose;
using hal::Vec3;

/// What a solid is part of; gives its colour where it has none of its own, and what a view is fitted to.
enum class SolidRole : std::uint8_t { Ground, Target, Partner, Robot, Hand, Clutter, Wall };

/// A solid primitive in W, as the simulator has it; a half space is an endless ground.
struct Solid : sim_hal::Shape {
  SolidRole role = SolidRole::Clutter;
  std::optional<Colour> colour = std::nullopt;
};
/// With the role that its label tells.
[[nodiscard]] Solid solid_of(const sim_hal::Shape& shape);

/// A scene made of primitives, to be drawn.
struct SolidScene {
  std::vector<Solid> solids;
};

[[nodiscard]] Colour colour_of(SolidRole role);

/// The robot's links where these joint positions put them; arm and hand have roles of their own.
[[nodiscard]] std::vector<Solid> robot_solids(const hal::RobotModel& model, const hal::JointVector& q_rad,
                                              const hal::HandPosture& hand);

/// Where a scene is seen from. Rows of the image are level with Wz.
struct SolidView {
  Vec3 eye{2.5, -2.0, 1.6};
  Vec3 target{0.5, 0.0, 0.5};
  double angle_deg = 32.0;  ///< Of view, over the height of the image; ignored with `height_m`.
  std::optional<double> height_m = std::nullopt;  ///< Parallel projection: what the image's height shows (m).
  int width = 1280, height = 800;
  bool film = false;  ///< One picture of many: coarser shadows and edges, for a tenth of the time.

  /// The camera that sees this; for a parallel projection one that is very far away.
  [[nodiscard]] Pose X_WC() const;
  [[nodiscard]] hal::CameraIntrinsics intrinsics() const;

  /// Where a point comes to lie in the image; nullopt behind the eye.
  [[nodiscard]] std::optional<Px> at(const Vec3& p_W) const;
};

/// The view from the direction `from` (W, towards the eye) that shows all solids but ground and walls.
[[nodiscard]] SolidView view_of(const SolidScene& scene, const Vec3& from, int width, int height);

/// Casts the scene into an image: soft key light with shadows, sky light with ambient occlusion, smooth
/// edges. RGB bytes, width * height. Deterministic.
[[nodiscard]] std::vector<std::uint8_t> cast_solids(const SolidScene& scene, const SolidView& view);

/// The same as a canvas to draw on.
[[nodiscard]] Canvas draw_solids(const SolidScene& scene, const SolidView& view);

}  // namespace colift::picture
