#pragma once

#include <string>

#include "sim_hal/scenario/scenario.hpp"

namespace colift::sim_hal {

/// The file that says a scenario, but for its name: parse_scenario() reads the same values from it, to the
/// last bit. Every entry that matters is there, also where it has its default.
[[nodiscard]] std::string yaml_of(const Scenario& scenario);

}  // namespace colift::sim_hal
