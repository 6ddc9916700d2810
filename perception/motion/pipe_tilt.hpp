#pragma once

#include <optional>

#include "perception/scene.hpp"

namespace colift::perception {

/// Axis of a target whose completed shape is one of its cylinders; none for any other.
[[nodiscard]] std::optional<Vec3> pipe_axis(const Scene& scene);

/// How much the slope of an axis changed by a motion (rad). A pipe that turns about its axis stays level, and
/// the view does not hold that angle: the blocks that it lay on, one thing with it for the camera, turn its
/// estimate by 10 degrees when it is raised off them.
[[nodiscard]] double slope_change(const hal::Pose& X_WTnow_WTref, const Vec3& axis, const Vec3& up);

}  // namespace colift::perception
