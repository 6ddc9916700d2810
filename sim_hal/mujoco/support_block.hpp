#pragma once

#include <optional>

#include "sim_hal/mujoco/engine/mjcf.hpp"

namespace colift::sim_hal {

/// The fixed block that stands in for a human hand in the thesis's experiments (6.3.1): 6 x 6 cm, from the
/// floor to the object's underside behind the grasp point, as near to the grasp as there is room (beside a
/// leg it moves inwards). nullopt where the object itself reaches the floor: then the floor is the support.
[[nodiscard]] std::optional<SupportBlock> support_block(const Scenario& scenario, const ObjectParts& object);

}  // namespace colift::sim_hal
