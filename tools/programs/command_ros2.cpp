// Options of the bridge to ROS 2.

#include "tools/dds/serve/cmd_ros2.hpp"
#include "tools/programs/command_line.hpp"

namespace colift::tools {

void add_ros2_commands(CommandLine& line) {
  CommonOptions& common = line.common;
  CLI::App& command = line.command("ros2");
  const auto options = std::make_shared<Ros2ServeOptions>();
  add_ros2_place(command, options->ros2);
  command.add_option("--count", options->count, "Ends after N answers (default: when it is interrupted)")
      ->type_name("N");
  line.add_common(command);
  line.when(command, [&common, options] { return cmd_ros2(common, *options); });
}

}  // namespace colift::tools
