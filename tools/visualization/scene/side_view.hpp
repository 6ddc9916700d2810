#pragma once

#include <optional>
#include <string>

#include "tools/visualization/scene/solid_scene.hpp"

namespace colift::picture {

/// Before and at the top of a lift, seen from the side in parallel projection, both at the same scale.
struct SideView {
  SolidScene before, lifted;
  Vec3 partner = Vec3::Zero(), robot = Vec3::Zero();  ///< Grasp points before the lift (W, m).
  std::optional<double> height_m = std::nullopt;      ///< Of the lift, as measured.
  std::optional<double> tilt_rad = std::nullopt;
  std::optional<double> share = std::nullopt;    ///< The robot's part of the load at the top.
  std::optional<Vec3> seen_from = std::nullopt;  ///< Looks from this point's side of the line.
  int width = 1280;
};

/// Two pictures one beside the other: looking across the line from partner to robot, the object's height
/// before marked in both, height, tilt and both shares written at the top one.
[[nodiscard]] Canvas draw_side_view(const SideView& what);

}  // namespace colift::picture
