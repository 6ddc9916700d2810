// Options of the live view, for every command that has one.

#include "tools/programs/command_line.hpp"

namespace colift::tools {

void add_view(CLI::App& parser, ViewOptions& o) {
  parser
      .add_option_function<std::vector<std::string>>(
          "--view", [&o](const std::vector<std::string>& port) { o.view = port.empty() ? "" : port.front(); },
          "Shows it on a page in the browser, and to Foxglove and Lichtblick (default port 8765)")
      ->expected(0, 1)
      ->type_name("[PORT]");
  parser
      .add_option("--view-address", o.view_address, "Where the page is served (default: this machine alone)")
      ->type_name("ADDRESS");
  parser.add_flag("--allow-operator", o.allow_operator,
                  "Clients that know the printed token may stop the run");
  parser.add_option("--allow-origin", o.allow_origins, "Allows pages of this origin to connect")
      ->type_name("URL");
  parser
      .add_option("--speed", o.speed,
                  "Simulation speed as a multiple of real time (default: 1 with --view, else unlimited)")
      ->type_name("X");
}

void add_ros2_place(CLI::App& command, Ros2Options& o) {
  command.add_option("--ros2-domain", o.domain, "DDS domain, 0 to 101 (default: ROS_DOMAIN_ID, else 0)")
      ->type_name("N");
  command.add_option("--ros2-interface", o.interface, "Network interface instead of the loopback one")
      ->type_name("NAME");
}

}  // namespace colift::tools
