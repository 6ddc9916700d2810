#pragma once

#include "control/config/config.hpp"

namespace colift::control {

/// Config as Config::arm_mode wants it: in T1 the last gate, planned trajectories and the lift keep to
/// hal/guards/t1_profile.hpp; what is set slower stays so.
[[nodiscard]] Config for_arm_mode(Config config);

}  // namespace colift::control
