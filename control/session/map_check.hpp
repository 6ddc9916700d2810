#pragma once

#include <optional>
#include <string>

#include "control/config/check_config.hpp"
#include "perception/map/world_map.hpp"
#include "perception/organised_cloud.hpp"

namespace colift::control {

/// Why a collision world cannot be the room that the camera saw: most of what is known of it is occupied, or
/// most of what the camera saw is missing in it. Unset: it can. One sentence with numbers; a plan through
/// such a map would mean nothing. `cloud`: what the map was made from. Some milliseconds.
[[nodiscard]] std::optional<std::string> map_fault(const perception::WorldMap& map,
                                                   const perception::OrganisedCloud& cloud,
                                                   const MapCheckConfig& config = {});

}  // namespace colift::control
