#pragma once

#include "control/config/config.hpp"
#include "control/session/look.hpp"

namespace colift::control {

/// What a run changes in the thesis's perception, before files and --set are read. The thesis leaves these
/// numbers open; PCL's usual ones lose the rim of a table, 25 mm high, on which its grasps lie.
void set_thesis_defaults(Config& config);

/// Gives a configuration what goes with a method. For the thesis's: its prices of effort, nothing refused
/// that it does not refuse (sections 4.3, 5.3.4), and a tracker that suits the noise and the pace of its
/// partner's grasp; what is set more patient stays. Nothing for the fast one.
void use_method(Method method, Config& config);

}  // namespace colift::control
