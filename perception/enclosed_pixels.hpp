#pragma once

#include <cstdint>
#include <vector>

#include "perception/organised_cloud.hpp"
#include "perception/scene.hpp"

namespace colift::perception {

/// Pixels that an object surrounds in the image and that lie over its footprint: the bottom of an open box, a
/// seat behind the slats of a back rest. They belong to it although no path of equal depth leads there.
/// `pixels`: ascending, the object's own. `barred`: per pixel, not 0 where something else is known to be. The
/// result is ascending.
[[nodiscard]] std::vector<std::uint32_t> enclosed_pixels(const OrganisedCloud& cloud, const Ground& ground,
                                                         const std::vector<std::uint32_t>& pixels,
                                                         const std::vector<std::uint8_t>& barred);

}  // namespace colift::perception
