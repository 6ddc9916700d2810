#include "tools/experiments/cmd_experiment.hpp"

#include <fmt/format.h>

#include <charconv>
#include <cstdio>

#include "tools/cli/interrupt.hpp"
#include "tools/cli/session.hpp"
#include "tools/experiments/outcome.hpp"
#include "tools/experiments/trials/sighting.hpp"
#include "tools/experiments/worst.hpp"

namespace colift::tools {
namespace {

using namespace experiments;
using hal::ErrorCode;

hal::Result<CampaignOptions> campaign_options(const ExperimentOptions& o) {
  CampaignOptions c;
  c.trials = o.trials;
  c.seed = o.seed;
  c.jobs = o.jobs;
  c.out = o.out;
  if (o.trials < 0) return hal::failure(ErrorCode::BadInput, "--trials", "has to be 1 or more");
  if (o.method == "fast") {
    c.methods = Methods::Fast;
  } else if (o.method == "thesis") {
    c.methods = Methods::Thesis;
  } else if (o.method == "both") {
    c.methods = Methods::Both;
  } else {
    return hal::failure(ErrorCode::BadInput, "--method",
                        fmt::format("\"{}\" is not known, expected fast, thesis or both", o.method));
  }
  if (o.camera == "side") {
    c.view = View::Side;
  } else if (o.camera != "layout") {
    return hal::failure(ErrorCode::BadInput, "--camera",
                        fmt::format("\"{}\" is not known, expected layout or side", o.camera));
  }
  const char* end = o.shard.data() + o.shard.size();
  const auto [slash, bad] = std::from_chars(o.shard.data(), end, c.shard);
  const bool split = bad == std::errc() && slash != end && *slash == '/';
  const auto last = split ? std::from_chars(slash + 1, end, c.shards)
                          : std::from_chars_result{end, std::errc::invalid_argument};
  if (last.ec != std::errc() || last.ptr != end || c.shard < 1 || c.shard > c.shards)
    return hal::failure(ErrorCode::BadInput, "--shard",
                        fmt::format("\"{}\" is not I/N with I from 1 to N, as in 2/8", o.shard));
  return c;
}

std::string names() {
  std::string all;
  for (const Experiment& e : all_experiments()) all += e.name + ", ";
  return all + "all";
}

std::string clock_text(double s) {
  const int whole = static_cast<int>(s + 0.5);
  if (whole >= 3600) return fmt::format("{}:{:02d} h", whole / 3600, whole / 60 % 60);
  return fmt::format("{}:{:02d} min", whole / 60, whole % 60);
}

hal::Result<> put_out(const Experiment& e, const Campaign& campaign, const std::filesystem::path& folder,
                      const CommonOptions& common) {
  if (auto ok = write_outcome(e, campaign, folder); !ok) return ok;
  if (common.json)
    std::fputs(experiment_document(e, campaign).c_str(), stdout);
  else
    std::fputs((experiment_text(e, campaign) + "\n").c_str(), stdout);
  std::fflush(stdout);
  return {};
}

/// Several experiments are one document: an array under "experiments".
class JsonFrame {
 public:
  JsonFrame(bool json, bool several) : several_(json && several), json_(json) {
    if (several_) std::fputs("{\"schema\":\"colift.experiments/1\",\"experiments\":[", stdout);
  }
  void next() {
    if (several_ && !first_) std::fputs(",", stdout);
    first_ = false;
  }
  ~JsonFrame() {
    if (several_) std::fputs("]}", stdout);
    if (json_) std::fputs("\n", stdout);
    std::fflush(stdout);
  }

 private:
  bool several_, json_, first_ = true;
};

int merge(const CommonOptions& common, const ExperimentOptions& options) {
  const std::vector<std::filesystem::path> from(options.words.begin() + 1, options.words.end());
  if (from.empty())
    return report_error("experiment",
                        {ErrorCode::BadInput, "merge", "which folders? merge DIR... --out DIR"});
  // everything is checked before the document begins
  std::vector<std::pair<const Experiment*, Campaign>> merged;
  for (const std::filesystem::path& folder : from) {
    std::error_code ignored;
    if (!std::filesystem::is_directory(folder, ignored))
      return report_error("experiment", {ErrorCode::BadInput, folder.string(), "is no folder"});
  }
  for (const Experiment& e : all_experiments()) {
    bool any = false;
    for (const std::filesystem::path& folder : from) {
      std::error_code ignored;
      any = any || std::filesystem::exists(folder / (e.name + ".csv"), ignored);
    }
    if (!any) continue;
    auto campaign = merge_campaigns(e, from, options.out);
    if (!campaign) return report_error("experiment", campaign.error());
    merged.emplace_back(&e, std::move(*campaign));
  }
  if (merged.empty())
    return report_error("experiment",
                        {ErrorCode::BadInput, from.front().string(), "holds no table of an experiment"});
  {
    JsonFrame frame(common.json, merged.size() > 1);
    for (const auto& [e, campaign] : merged) {
      frame.next();
      if (auto ok = put_out(*e, campaign, options.out, common); !ok)
        return report_error("experiment", ok.error());
    }
  }
  if (auto ok = write_index(options.out); !ok) return report_error("experiment", ok.error());
  if (!common.quiet) std::fprintf(stderr, "page: %s\n", (options.out / "index.html").c_str());
  return kDone;
}

// worst NAME: the trials of a finished campaign that went worst, each with its picture and its cause
int show_worst(const CommonOptions& common, const ExperimentOptions& options) {
  const Experiment* e = options.words.size() == 2 ? find_experiment(options.words[1]) : nullptr;
  if (e == nullptr)
    return report_error("experiment",
                        {ErrorCode::BadInput, "worst", "of which experiment? worst NAME --out DIR"});
  WorstOptions worst;
  if (options.trials > 0) worst.count = options.trials;
  worst.folder = options.out;
  const InterruptGuard signals;
  const auto page = write_worst(*e, worst, [&](const std::string& words) {
    if (!common.quiet) std::fputs((words + "\n").c_str(), stderr);
    return !InterruptGuard::asked();
  });
  if (!page) return report_error("experiment", page.error());
  if (!common.quiet) std::fprintf(stderr, "page: %s\n", page->c_str());
  return kDone;
}

}  // namespace

hal::Result<control::ResolvedConfig> config_of_experiment(const ExperimentOptions& o) {
  const auto campaign = campaign_options(o);
  if (!campaign) return tl::unexpected(campaign.error());
  if (campaign->methods == Methods::Both)
    return hal::failure(ErrorCode::BadInput, "--method",
                        "both are two configurations; expected fast or thesis");
  const Experiment* e = o.words.size() == 1 ? find_experiment(o.words.front()) : nullptr;
  if (e == nullptr)
    return hal::failure(ErrorCode::BadInput, "NAME",
                        "each experiment has a configuration of its own; expected one of them");
  const bool fast = campaign->methods == Methods::Fast;
  auto resolved = resolved_for(fast ? control::Method::Fast : control::Method::Thesis, e->task);
  if (!e->trials_set.empty())
    resolved.warnings.push_back(fmt::format("the trials of {} also set {}", e->name, e->trials_set));
  return resolved;
}

int cmd_experiment(const CommonOptions& common, const ExperimentOptions& options) {
  if (options.words.front() == "merge") return merge(common, options);
  if (options.words.front() == "worst") return show_worst(common, options);
  if (options.words.size() > 1)
    return report_error("experiment", {ErrorCode::BadInput, options.words[1], "one NAME at a time"});
  auto campaign_setting = campaign_options(options);
  if (!campaign_setting) return report_error("experiment", campaign_setting.error());

  const std::string& name = options.words.front();
  std::vector<const Experiment*> to_run;
  for (const Experiment& e : all_experiments())
    if ((name == "all" && !e.real_time) || name == e.name) to_run.push_back(&e);
  if (to_run.empty())
    return report_error("experiment", {ErrorCode::BadInput, "NAME",
                                       fmt::format("\"{}\" is no experiment; there are {}", name, names())});

  const InterruptGuard signals;
  bool complete = true;
  {
    JsonFrame frame(common.json, to_run.size() > 1);
    for (const Experiment* e : to_run) {
      CampaignHooks hooks;
      hooks.interrupted = [] { return InterruptGuard::asked(); };
      hooks.progress = [&](const CampaignProgress& p) {
        if (common.quiet) return;
        std::fputs(
            fmt::format("{} {}/{}, {} left: {}\n", e->name, p.done, p.to_do, clock_text(p.left_s), p.words)
                .c_str(),
            stderr);
      };
      const auto campaign = run_campaign(*e, *campaign_setting, hooks);
      if (!campaign) return report_error("experiment", campaign.error());
      frame.next();
      if (auto ok = put_out(*e, *campaign, options.out, common); !ok)
        return report_error("experiment", ok.error());
      complete = campaign->complete;
      if (!complete) break;
    }
  }
  if (auto ok = write_index(options.out); !ok) return report_error("experiment", ok.error());
  if (!complete) {
    std::fputs("interrupted; the same command continues from here\n", stderr);
    return kInterrupted;
  }
  if (!common.quiet) std::fprintf(stderr, "page: %s\n", (options.out / "index.html").c_str());
  return kDone;
}

}  // namespace colift::tools
