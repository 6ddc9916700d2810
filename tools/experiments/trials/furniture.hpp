#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "sim_hal/scenario/scenario.hpp"

namespace colift::experiments {

/// What people carry in pairs beside tables, boxes, pipes and chairs, in the order of the trials: a stool, a
/// shelf, a ladder (on its edge, or a step ladder that stands open), a crate without a lid, a suitcase with
/// handles, a box with an overhanging lid, a bench, and a frame of tubes like a bicycle's.
[[nodiscard]] const std::vector<std::string>& furniture_kinds();

/// A random one of kind `index % 8`, of several bodies with their own densities, its near side within the
/// arm's reach and a partner at its far side. Same arguments, same scene.
[[nodiscard]] sim_hal::Scenario furniture_layout(int index, std::uint64_t seed);

}  // namespace colift::experiments
