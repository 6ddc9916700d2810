#pragma once

#include "hal/types/geometry.hpp"

namespace colift::control {

/// A point (W) in a box's own frame, from its middle (m).
[[nodiscard]] inline hal::Vec3 in_frame_of(const hal::OrientedBox& box, const hal::Vec3& p_W) {
  return box.axes.transpose() * (p_W - box.center);
}

/// Whether a point (W) lies in a box that is larger by `margin_m` on each side.
[[nodiscard]] inline bool is_inside(const hal::OrientedBox& box, const hal::Vec3& p_W, double margin_m) {
  return (in_frame_of(box, p_W).cwiseAbs().array() <= (0.5 * box.size).array() + margin_m).all();
}

}  // namespace colift::control
