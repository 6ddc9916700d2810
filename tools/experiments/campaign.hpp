#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "hal/types/result.hpp"
#include "tools/experiments/experiment.hpp"

namespace colift::experiments {

enum class Methods { Fast, Thesis, Both };
[[nodiscard]] const char* word(Methods methods);

struct CampaignOptions {
  int trials = 0;  ///< 0: the experiment's own number.
  std::uint64_t seed = 1;
  Methods methods = Methods::Fast;
  View view = View::OfLayout;
  int shard = 1, shards = 1;  ///< Trials whose number modulo `shards` is shard - 1.
  int jobs = 0;               ///< Threads; 0: one per core.
  std::filesystem::path out = "out/experiments";
};

/// Told to whoever watches, from any of the threads but never from two at once.
struct CampaignProgress {
  int done = 0, to_do = 0, kept = 0;  ///< Trials of this call; trials that an earlier one had done.
  double left_s = 0.0;                ///< At the pace so far.
  std::string words;                  ///< On the trial that has ended.
};

struct CampaignHooks {
  std::function<void(const CampaignProgress&)> progress;
  std::function<bool()> interrupted;  ///< Trials that run are finished, then it ends.
};

/// The two tables of an experiment.
struct Campaign {
  TrialTable trials, details;
  bool complete = true;  ///< False when it was interrupted.
};

/// Runs what is missing of a campaign. Rows go to DIR/NAME.csv and DIR/NAME_grasps.csv as trials end, details
/// first, so that an interrupted campaign goes on where it was; at the end both are sorted by trial. Trials
/// do not depend on each other, nor on threads or shards. Errors: BadInput (a table there that belongs to
/// another campaign, a folder that cannot be written, shard or trials out of range), BadConfig (a method that
/// this build lacks).
[[nodiscard]] hal::Result<Campaign> run_campaign(const Experiment& experiment, const CampaignOptions& options,
                                                 const CampaignHooks& hooks);

/// Joins the tables of several folders and writes them to `out`. Errors: BadInput (none there, campaigns that
/// differ, one trial with two results).
[[nodiscard]] hal::Result<Campaign> merge_campaigns(const Experiment& experiment,
                                                    const std::vector<std::filesystem::path>& from,
                                                    const std::filesystem::path& out);

/// The tables as they stand in a folder. Errors: BadInput.
[[nodiscard]] hal::Result<Campaign> read_campaign(const Experiment& experiment,
                                                  const std::filesystem::path& folder);

/// What the header of its table says under a name: "7" for "seed" of "colift.experiment/1 mass seed=7
/// method=fast".
[[nodiscard]] std::optional<std::string> header_value(const Campaign& campaign, const std::string& name);

/// The rows of one method. The campaign stays as it is.
[[nodiscard]] Campaign of_method(const Campaign& campaign, const std::string& method);
/// Methods that have rows, in the order fast, thesis.
[[nodiscard]] std::vector<std::string> methods_of(const Campaign& campaign);

}  // namespace colift::experiments
