#pragma once

#include <filesystem>
#include <functional>
#include <string>

#include "hal/types/result.hpp"
#include "tools/experiments/experiment.hpp"

namespace colift::experiments {

struct WorstOptions {
  int count = 20;
  std::filesystem::path folder = "out/experiments";  ///< Of the campaign, and of the page.
};

/// Ranks the trials of a finished campaign by Experiment::badness, makes the worst of them once more and
/// writes NAME_worst.html: what each was, how it ended and why, and what the camera saw when it was decided.
/// `progress` is told of each; false ends it early. Errors: BadInput (no campaign there, an experiment that
/// does not rank its trials, no trial that counts, a page that cannot be written).
[[nodiscard]] hal::Result<std::filesystem::path> write_worst(
    const Experiment& experiment, const WorstOptions& options,
    const std::function<bool(const std::string&)>& progress);

}  // namespace colift::experiments
