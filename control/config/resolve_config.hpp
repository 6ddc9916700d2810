#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "control/config/config.hpp"
#include "control/config/method.hpp"
#include "hal/types/result.hpp"

namespace colift::control {

/// What has a configuration. Each has defaults of its own.
enum class Command { Run, SceneAnalysis, Decide, Calibrate, Hal, Experiment, Replay };

/// What a scenario, or an experiment, says about the task.
struct TaskSaid {
  std::string origin;  ///< "scenario table".
  double lift_height_m = 0.05, hold_s = 2.0;
};

/// An option of a command line that stands for an entry, --share for decision.share.
struct OptionValue {
  std::string path;
  std::string value;   ///< As typed.
  std::string option;  ///< "--share": origin of the value, and place of an error.
};

/// The configuration in a recording: what that run worked with.
struct RecordedConfig {
  std::string yaml;
  Method method = Method::Fast;
  /// Whether the text holds what either method used. Up to version 0.1 a run with the thesis's method did not
  /// record its candidates' settings, which could not be changed then.
  bool complete = true;
};

/// What a configuration is made from: command, scenario, files, settings and options, in the order in which
/// they count.
struct ConfigRequest {
  Command command = Command::Run;
  std::optional<TaskSaid> task;
  std::optional<RecordedConfig> recorded;  ///< Stands for defaults, method and task.
  std::vector<std::string> files;          ///< --config, in their order.
  std::vector<std::string> settings;       ///< --set, in their order.
  std::vector<OptionValue> options;
};

/// A configuration, and who said each of its values.
struct ResolvedConfig {
  Config config;
  Method method = Method::Fast;  ///< As config.method.
  /// By path, of all values that are no plain default: "run's default", "method thesis", "scenario table",
  /// "my.yaml:3", "--set", "--share", "decision.share (--share)", "arm_mode t1".
  std::map<std::string, std::string> origins;
  /// What was accepted and should be looked at, such as old names of entries; for stderr.
  std::vector<std::string> warnings;
};

/// The one maker of configurations. The later wins, value by value: the command's defaults, those of the
/// method (whoever names it: option, setting or file), the scenario's task, files, settings, options; last,
/// where arm_mode says t1, what is faster than T1 allows is made slower.
///
/// decision.share and decision.weights.epsilon say the same thing: what was said last counts. One file that
/// gives both has to give equal ones.
///
/// Errors: BadConfig with the place.
[[nodiscard]] hal::Result<ResolvedConfig> resolve_config(const ConfigRequest& request);

/// As YAML that reads back to the same bits, each value with its origin; with `explain` also with meaning,
/// range and unit.
[[nodiscard]] std::string yaml_of(const ResolvedConfig& resolved, bool explain = false);

}  // namespace colift::control
