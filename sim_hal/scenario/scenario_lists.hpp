#pragma once

#include <string>

#include "hal/config/yaml_tree.hpp"
#include "hal/types/result.hpp"

namespace colift::sim_hal {

/// Entries of a scenario that a configuration's fields cannot hold as they are written: of every person the
/// path [[x, y], ...] becomes [x, y, ...], and reach_to: [x, y, z] becomes reach_to: point, point: [x, y, z].
/// Errors: BadConfig with the place of a point that is no [x, y].
[[nodiscard]] hal::Result<> flatten_lists(hal::YamlTree& tree, const std::string& name);

}  // namespace colift::sim_hal
