#pragma once

#include <optional>
#include <vector>

#include "planner/grasp/grasp_lines.hpp"
#include "planner/hand/obstacles.hpp"
#include "planner/hand/seen_space.hpp"

namespace colift::planner {

/// How far a body goes on behind a face that is grasped, as on a bar, a rung, a leg or a handle (m along the
/// approach): to the object's last point between the fingers, and not to where the camera looked through
/// behind the face. Never deeper than wide by that space, and at least half as deep as wide; three quarters
/// where the camera saw past both of its sides, but not behind it. As deep as wide where nothing of it shows
/// behind the face. Median of places along the line. None where it goes on up to `reach_m`, as behind the rim
/// of a plate.
[[nodiscard]] std::optional<double> body_depth(const GraspLine& line, const Obstacles& obstacles,
                                               const SeenSpace& seen, double reach_m);

/// The sides beside the face of bars no thicker than `max_bar_m`, whose depth is known: at the distance of a
/// camera the faces of a handle are a few pixels wide, and one of them stands for all. Without the sides that
/// `lines` has already.
[[nodiscard]] std::vector<GraspLine> bar_lines(const std::vector<GraspLine>& lines, const Vec3& up,
                                               double max_bar_m);

}  // namespace colift::planner
