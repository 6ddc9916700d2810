#include "tools/bring_up/bring_up.hpp"

#include <fmt/format.h>

#include <cstdio>

#include "tools/cli/config_of.hpp"

namespace colift::tools {

hal::Result<RobotFile> read_wired(const HalOptions& options, const WiredDevice& device) {
  auto file = read_robot_file(options.robot);
  if (!file) return file;
  const std::string& kind = (*file).*device.kind;
  if (options.robot && kind != device.driver)
    return hal::failure(hal::ErrorCode::BadConfig, options.robot->string(),
                        fmt::format("its {} is {}; bring-up is for a device on a wire, expected {}: {}",
                                    device.name, kind, device.name, device.driver));
  return file;
}

hal::Result<control::Config> read_config(const char* command, const CommonOptions& common) {
  auto resolved = config_of(common, control::Command::Hal);
  if (!resolved) return tl::unexpected(resolved.error());
  show_warnings(command, common, *resolved);
  return std::move(resolved->config);
}

hal::Result<> check_time(const HalOptions& options) {
  if (!options.for_s || *options.for_s > 0.0) return {};
  return hal::failure(hal::ErrorCode::BadInput, "--for", "expected more than 0 s");
}

LiveScreen progress_screen(const CommonOptions& common, const HalOptions& options,
                           std::string_view printing_verb) {
  return {common.json ? stderr : stdout, common.json, common.quiet || options.verb == printing_verb};
}

void report_failure(const char* device, const std::string& verb, const std::string& reason,
                    const std::optional<std::string>& next) {
  std::string text = fmt::format("colift hal {} {}: {}\n", device, verb, reason);
  if (next) text += fmt::format("{}docs/bring-up.md says more\n", *next);
  std::fputs(text.c_str(), stderr);
}

}  // namespace colift::tools
