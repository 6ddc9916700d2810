#include <fmt/format.h>

#include <cstdio>
#include <nlohmann/json.hpp>

#include "hal/config/config_file.hpp"
#include "hal/config/effective_yaml.hpp"
#include "tools/colift/commands.hpp"
#include "tools/colift/session.hpp"

namespace colift::tools {

int cmd_check(const CommonOptions& common, bool help) {
  control::Config config;
  hal::FieldTable table = hal::table_of(config);
  if (auto done = hal::apply_command_line(table, common.config_files, common.settings); !done)
    return report_error("check", done.error());
  const auto setup = load_setup(common);
  if (!setup) return report_error("check", setup.error());

  const std::string yaml = hal::effective_yaml(table, help);
  if (common.json) {
    nlohmann::ordered_json j = {{"schema", "colift.check/1"}, {"ok", true}, {"hand", setup->hand.name}};
    j["changed"] = nlohmann::ordered_json::object();
    for (const auto& field : table.fields())
      if (field.origin != hal::kDefaultOrigin) j["changed"][field.path] = field.origin;
    j["config"] = yaml;
    std::puts(j.dump().c_str());
    return kDone;
  }
  if (!common.quiet) std::fputs(yaml.c_str(), stdout);
  fmt::print(stderr, "the configuration is usable; hand: {}\n", setup->hand.name);
  return kDone;
}

}  // namespace colift::tools
