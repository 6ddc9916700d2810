#pragma once

#include "perception/map/world_map.hpp"

namespace colift::perception {

/// Part of the cells in a box (W) of which no frame says whether they are free or occupied, without the
/// target's own; 0 to 1, NaN where the box lies outside of the map.
[[nodiscard]] double unseen_fraction(const WorldMap& map, const hal::Aabb& box_W);

/// The space around an object in which hand and partner work: its box, grown sideways by 0.3 m, from the
/// ground to 0.1 m above it.
[[nodiscard]] hal::Aabb space_around(const hal::OrientedBox& object, double ground_z_m);

}  // namespace colift::perception
