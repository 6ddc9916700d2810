#pragma once

#include <cstdint>
#include <vector>

#include "perception/ground_and_target/components.hpp"
#include "perception/organised_cloud.hpp"
#include "perception/scene.hpp"

namespace colift::perception {

/// Pixels that an object surrounds in the image and that lie over its footprint: the bottom of an open box, a
/// seat behind the slats of a back rest. They belong to it although no path of equal depth leads there.
/// `pixels`: ascending, the object's own. `barred`: per pixel, not 0 where something else is known to be.
/// Pixels with fewer than `min_neighbours` of the eight around them on one surface by `jump` are left out:
/// between an edge and what lies behind it a pixel shows a depth at which there is nothing. The result is
/// ascending.
[[nodiscard]] std::vector<std::uint32_t> enclosed_pixels(const OrganisedCloud& cloud, const Ground& ground,
                                                         const std::vector<std::uint32_t>& pixels,
                                                         const std::vector<std::uint8_t>& barred,
                                                         const DepthJump& jump, int min_neighbours);

}  // namespace colift::perception
