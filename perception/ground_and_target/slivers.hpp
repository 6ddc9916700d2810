#pragma once

#include <cstdint>
#include <vector>

#include "perception/noise_model.hpp"
#include "perception/organised_cloud.hpp"
#include "perception/scene.hpp"

namespace colift::perception {

/// Pixels, ascending, that stand in the target's box without being its own, in regions too small to be a
/// thing: slivers of a post that the rest of it half hides, what lies between an edge and its background, a
/// cup on the seat. No surface can rest on them, but they go where the target goes. Regions of which a part
/// stands outside of the box are something else. Needs Target::pixels; without them there are none.
[[nodiscard]] std::vector<std::uint32_t> find_slivers(const OrganisedCloud& cloud, const Target& target,
                                                      const Ground& ground, const NoiseModel& noise);

}  // namespace colift::perception
