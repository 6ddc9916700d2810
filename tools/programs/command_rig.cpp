// --scenario, --robot and recorded frames: a path, or the name of what is shipped.

#include "tools/cli/shipped_files.hpp"
#include "tools/programs/command_line.hpp"

namespace colift::tools {
namespace {

template <class Path>
CLI::Option* add_shipped(CLI::App& parser, const char* option, Path& file, const std::string& help,
                         ShippedKind kind) {
  return parser.add_option(option, file, help)
      ->type_name("NAME|FILE")
      ->transform([=](const std::string& text) {
        const auto found = file_or_shipped(kind, text);
        if (!found) throw CLI::ValidationError(found.error().where + ": " + found.error().detail);
        return found->string();
      });
}

}  // namespace

CLI::Option* add_scenario(CLI::App& parser, std::optional<std::filesystem::path>& file,
                          const std::string& help) {
  return add_shipped(parser, "--scenario", file, help, ShippedKind::Scenario);
}

CLI::Option* add_robot(CLI::App& parser, std::optional<std::filesystem::path>& file,
                       const std::string& help) {
  return add_shipped(parser, "--robot", file, help, ShippedKind::Robot);
}

CLI::Option* add_frame(CLI::App& parser, const char* option, std::filesystem::path& file,
                       const std::string& help) {
  return add_shipped(parser, option, file, help, ShippedKind::Scene);
}

}  // namespace colift::tools
