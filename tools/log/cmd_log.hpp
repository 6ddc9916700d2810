#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "control/config/resolve_config.hpp"
#include "tools/cli/options.hpp"

namespace colift::tools {

/// What the verbs of `log` take.
struct LogOptions {
  std::string verb;  ///< info | compare | export | recover | replay | snapshot
  std::filesystem::path file;
  std::filesystem::path other;                  ///< compare: the second recording.
  std::optional<std::filesystem::path> beside;  ///< replay: another one, for the page.
  std::optional<std::filesystem::path> out;     ///< export: folder; recover: file; compare: page.
  std::vector<std::string> formats;             ///< export: csv, png, fakenect, ros2.
  std::optional<int> pid;                       ///< snapshot: which run.
  ViewOptions live;                             ///< replay: watched on the page.
};

/// Recordings. info, compare, export, recover: 0 done, 2 no usable recording. replay: 0 the same decisions, 1
/// others.
/// snapshot: 0 written, 1 no run to ask.
[[nodiscard]] int cmd_log(const CommonOptions& common, const LogOptions& options);

// One for each verb, in log_*.cpp.
[[nodiscard]] int log_info(const CommonOptions& common, const LogOptions& options);
[[nodiscard]] int log_compare(const CommonOptions& common, const LogOptions& options);
[[nodiscard]] int log_export(const CommonOptions& common, const LogOptions& options);
[[nodiscard]] int log_recover(const CommonOptions& common, const LogOptions& options);
[[nodiscard]] int log_replay(const CommonOptions& common, const LogOptions& options);

/// What a replay works with: the recorded configuration, with --config and --set over it. Errors: BadInput
/// (no usable recording), BadConfig with the place.
[[nodiscard]] hal::Result<control::ResolvedConfig> config_of_replay(const CommonOptions& common,
                                                                    const LogOptions& options);

}  // namespace colift::tools
