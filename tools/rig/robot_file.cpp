#include "tools/rig/robot_file.hpp"

#include "hal/config/config_file.hpp"

namespace colift::tools {

hal::Result<RobotFile> read_robot_file(const std::optional<std::filesystem::path>& file) {
  if (!file) return RobotFile{};
  return hal::load_yaml<RobotFile>(*file);
}

}  // namespace colift::tools
