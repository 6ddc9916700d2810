#pragma once

#include <optional>

#include "perception/scene.hpp"
#include "planner/hand/obstacles.hpp"
#include "planner/hand/seen_space.hpp"

namespace colift::planner {

/// A circle in the plane of a plate (W, m).
struct RoundPlate {
  Vec3 center = Vec3::Zero();
  double radius = 0.0;
};

/// The circle of a plate's rim, of which perception knows a rectangle: where three quarters of what is seen
/// of the rim lie on one circle, within the noise and 6 mm, and no third of the rim is hidden. None for a
/// plate with corners.
[[nodiscard]] std::optional<RoundPlate> find_round_plate(const perception::Rectangle& plate,
                                                         const Obstacles& obstacles, const SeenSpace& seen);

}  // namespace colift::planner
