#include "tools/telemetry/channels/built_in_texts.hpp"

namespace colift::telemetry {

std::string built_in_robot_urdf() {
  return
#include "built_in_robot.inc"
      ;
}

std::string built_in_scenario_yaml() {
  return
#include "built_in_scenario.inc"
      ;
}

std::string program_version() {
  return COLIFT_VERSION;
}

}  // namespace colift::telemetry
