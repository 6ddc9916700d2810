#pragma once

#include <optional>
#include <string>

#include "control/config/check_config.hpp"
#include "perception/organised_cloud.hpp"
#include "perception/scene.hpp"

namespace colift::control {

/// Why nothing is to be grasped in a picture: too many of the pixels on the target and about it see nothing
/// (sunlight, dark or shiny things). What is left of a large face looks like small ones, and behind a hole
/// may be anything. Unset: it has few enough. One sentence with numbers.
[[nodiscard]] std::optional<std::string> image_fault(const perception::OrganisedCloud& cloud,
                                                     const perception::Target& target,
                                                     const ImageCheckConfig& config = {});

}  // namespace colift::control
