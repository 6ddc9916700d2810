#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "control/config/resolve_config.hpp"
#include "tools/cli/options.hpp"

namespace colift::tools {

struct ExperimentOptions {
  std::vector<std::string> words;  ///< NAME, or "merge" and folders.
  int trials = 0;                  ///< 0: each experiment's own number.
  std::uint64_t seed = 1;
  std::string method = "fast";    ///< fast | thesis | both
  std::string camera = "layout";  ///< layout | side
  std::string shard = "1/1";
  int jobs = 0;
  std::filesystem::path out = "out/experiments";
};

/// Repeats experiments of the thesis in simulation, or joins shards. 0 done, 2 bad input, 130 interrupted
/// (what was done is kept, and the same command goes on from there).
[[nodiscard]] int cmd_experiment(const CommonOptions& common, const ExperimentOptions& options);

/// What the trials of one experiment work with; those whose point it is change mass or weights from trial to
/// trial. Errors: BadInput (no such experiment, both methods at once).
[[nodiscard]] hal::Result<control::ResolvedConfig> config_of_experiment(const ExperimentOptions& options);

}  // namespace colift::tools
