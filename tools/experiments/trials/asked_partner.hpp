#pragma once

#include <cstdint>

#include "hal/types/geometry.hpp"
#include "sim_hal/scenario/scenario.hpp"

namespace colift::experiments {

/// The scenario of a partner who was asked to grasp at `place` (W) of a box or table and went there. He
/// does not stand exactly where he was asked to: his hand is up to 3 cm beside in both level directions, as
/// the seed has it, but never beyond the object's edge.
[[nodiscard]] sim_hal::Scenario partner_goes_to(sim_hal::Scenario scenario, const hal::Vec3& place,
                                                std::uint64_t seed);

}  // namespace colift::experiments
