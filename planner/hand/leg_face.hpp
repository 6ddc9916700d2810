#pragma once

#include "perception/scene.hpp"
#include "planner/hand/seen_space.hpp"

namespace colift::planner {

/// Whether a face that goes down from a plate's edge is that of a leg and not the side of the whole: it takes
/// up a small part of the edge, and the camera looked past it into free space at most of the places beside it
/// where a side as deep would be. Such a face says nothing of how thick the plate is. `face` is perpendicular
/// to `plate` and lies below it.
[[nodiscard]] bool is_leg_face(const perception::Rectangle& face, const perception::Rectangle& plate,
                               const SeenSpace& seen);

/// Where a rectangle begins and ends along a unit vector (m).
struct Extent {
  double low, high;

  [[nodiscard]] double length() const { return high - low; }
};
[[nodiscard]] Extent extent_of(const perception::Rectangle& rectangle, const Vec3& direction);

}  // namespace colift::planner
