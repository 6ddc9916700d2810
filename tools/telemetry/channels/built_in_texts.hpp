#pragma once

#include <string>

namespace colift::telemetry {

// Texts that are compiled into the program, for the attachments of a recording.

[[nodiscard]] std::string built_in_robot_urdf();
[[nodiscard]] std::string built_in_scenario_yaml();
[[nodiscard]] std::string program_version();

}  // namespace colift::telemetry
