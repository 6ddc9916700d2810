#include <fmt/format.h>

#include <cstdio>
#include <nlohmann/json.hpp>

#include "control/task_machine.hpp"
#include "hal/config/config_file.hpp"
#include "hal/config/effective_yaml.hpp"
#include "tools/colift/commands.hpp"
#include "tools/colift/session.hpp"

namespace colift::tools {

namespace {

/// The rules of the job: a drawing for people, a list for programs.
int show_rules(bool json) {
  if (!json) {
    std::fputs(control::graph().c_str(), stdout);
    return kDone;
  }
  nlohmann::ordered_json j = {{"schema", "colift.rules/1"}};
  for (int t = 0; t < control::kTasks; ++t) {
    const auto task = static_cast<control::Task>(t);
    j["states"].push_back({{"state", control::word(task)},
                           {"waits_for", control::waits_for(task)},
                           {"end", control::is_end(task)},
                           {"loaded", control::is_loaded(task)},
                           {"moving", control::is_moving(task)}});
  }
  for (const control::Rule& rule : control::rules())
    j["rules"].push_back({{"from", control::word(rule.from)},
                          {"on", control::word(rule.on)},
                          {"to", control::word(rule.to)},
                          {"because", rule.because}});
  std::puts(j.dump().c_str());
  return kDone;
}

}  // namespace

int cmd_check(const CommonOptions& common, const CheckOptions& options) {
  if (options.graph) return show_rules(common.json);
  control::Config config;
  hal::FieldTable table = hal::table_of(config);
  if (auto done = hal::apply_command_line(table, common.config_files, common.settings); !done)
    return report_error("check", done.error());
  const auto setup = load_setup(common);
  if (!setup) return report_error("check", setup.error());

  const std::string yaml = hal::effective_yaml(table, options.explain);
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
