#pragma once

#include <cstdint>

#include "sim_hal/scenario/scenario.hpp"

namespace colift::experiments {

/// Furniture of several boxes, each of its own density: a desk with panels and a drawer unit, a bench on two
/// blocks, or a tabletop on trestles. Partner at its far side. Same arguments, same scene.
[[nodiscard]] sim_hal::Scenario bodies_layout(int index, std::uint64_t seed);

}  // namespace colift::experiments
