#include "tools/experiments/campaign.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <cstdio>
#include <mutex>
#include <set>
#include <sstream>
#include <thread>

#include "control/session/pipeline.hpp"
#include "hal/types/time.hpp"
#include "tools/visualization/file_output.hpp"

namespace colift::experiments {
namespace {

using hal::ErrorCode;
namespace fs = std::filesystem;

constexpr int kMostTrials = 1'000'000;

fs::path trials_file(const Experiment& e, const fs::path& folder) {
  return folder / (e.name + ".csv");
}
fs::path details_file(const Experiment& e, const fs::path& folder) {
  return folder / (e.name + "_grasps.csv");
}

std::vector<std::string> with_key(std::vector<std::string> columns) {
  columns.insert(columns.begin(), {"trial", "method"});
  return columns;
}

Campaign empty_campaign(const Experiment& e, const std::string& header) {
  return {TrialTable(header, with_key(e.columns)), TrialTable(header, with_key(e.detail_columns)), true};
}

hal::Result<> write_text(const fs::path& file, const std::string& text) {
  return picture::write_file(file, {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()});
}

hal::Result<> write_tables(const Experiment& e, Campaign& c, const fs::path& folder) {
  c.trials.sort();
  c.details.sort();
  if (!e.detail_columns.empty())
    if (auto ok = write_text(details_file(e, folder), c.details.text()); !ok) return ok;
  return write_text(trials_file(e, folder), c.trials.text());
}

std::set<int> trials_in(const TrialTable& table) {
  std::set<int> all;
  for (const Row& row : table.rows()) all.insert(TrialTable::trial_of(row));
  return all;
}

// what an earlier call has left, as far as it is whole
hal::Result<Campaign> kept_from(const Experiment& e, const CampaignOptions& o, const std::string& header) {
  Campaign kept = empty_campaign(e, header);
  std::error_code ignored;
  if (!fs::exists(trials_file(e, o.out), ignored)) return kept;
  auto there = read_campaign(e, o.out);
  if (!there) return there;
  if (there->trials.header() != header)
    return hal::failure(
        ErrorCode::BadInput, trials_file(e, o.out).string() + ":1",
        fmt::format("belongs to another campaign (\"{}\", this one is \"{}\"); choose another "
                    "--out or remove it",
                    there->trials.header(), header));
  // a trial with both methods is whole when both rows are there
  const int rows_each = o.methods == Methods::Both ? 2 : 1;
  std::map<int, int> rows;
  for (const Row& row : there->trials.rows()) ++rows[TrialTable::trial_of(row)];
  const auto unfinished = [&](int trial) { return rows[trial] != rows_each; };
  there->trials.erase_if_trial(unfinished);
  there->details.erase_if_trial(unfinished);
  return there;
}

std::vector<control::Method> list(Methods methods) {
  using control::Method;
  if (methods == Methods::Both) return {Method::Fast, Method::Thesis};
  return {methods == Methods::Fast ? Method::Fast : Method::Thesis};
}

/// Rows on their way to the disk.
class Appender {
 public:
  hal::Result<> open(const Experiment& e, const Campaign& kept, const fs::path& folder) {
    std::error_code error;
    fs::create_directories(folder, error);
    if (error)
      return hal::failure(ErrorCode::BadInput, folder.string(), "cannot be made: " + error.message());
    Campaign copy = kept;
    if (auto ok = write_tables(e, copy, folder); !ok) return ok;
    trials_ = std::fopen(trials_file(e, folder).c_str(), "ab");
    if (!e.detail_columns.empty()) details_ = std::fopen(details_file(e, folder).c_str(), "ab");
    if (trials_ == nullptr || (details_ == nullptr && !e.detail_columns.empty()))
      return hal::failure(ErrorCode::BadInput, folder.string(), "cannot be written");
    return {};
  }
  ~Appender() { close(); }
  Appender() = default;
  Appender(const Appender&) = delete;
  Appender& operator=(const Appender&) = delete;

  [[nodiscard]] bool add(const std::vector<Row>& rows, const std::vector<Row>& details) {
    bool good = true;
    if (details_ != nullptr) {
      for (const Row& row : details) good = put(details_, row) && good;
      good = std::fflush(details_) == 0 && good;
    }
    for (const Row& row : rows) good = put(trials_, row) && good;
    return std::fflush(trials_) == 0 && good;
  }
  void close() {
    if (trials_ != nullptr) std::fclose(trials_);
    if (details_ != nullptr) std::fclose(details_);
    trials_ = details_ = nullptr;
  }

 private:
  static bool put(std::FILE* file, const Row& row) {
    return std::fputs(TrialTable::line(row).c_str(), file) >= 0;
  }
  std::FILE* trials_ = nullptr;
  std::FILE* details_ = nullptr;
};

}  // namespace

const char* word(Methods methods) {
  return methods == Methods::Fast ? "fast" : methods == Methods::Thesis ? "thesis" : "both";
}

hal::Result<Campaign> run_campaign(const Experiment& e, const CampaignOptions& o,
                                   const CampaignHooks& hooks) {
  const int trials = o.trials == 0 ? e.default_trials : o.trials;
  if (trials < 1 || trials > kMostTrials)
    return hal::failure(ErrorCode::BadInput, "--trials",
                        fmt::format("is {}, expected 1 to {}", trials, kMostTrials));
  if (o.shards < 1 || o.shard < 1 || o.shard > o.shards)
    return hal::failure(ErrorCode::BadInput, "--shard",
                        fmt::format("is {}/{}, expected I/N with I from 1 to N", o.shard, o.shards));
  for (const control::Method method : list(o.methods))
    if (const auto made = control::make_pipeline(method); !made)
      return hal::failure(ErrorCode::BadConfig, "--method", made.error().detail);
  const std::string header = fmt::format("# colift.experiment/1 {} seed={} method={}{}", e.name, o.seed,
                                         word(o.methods), o.view == View::Side ? " camera=side" : "");
  auto kept = kept_from(e, o, header);
  if (!kept) return kept;
  Campaign& campaign = *kept;

  const std::set<int> have = trials_in(campaign.trials);
  std::vector<int> to_do;
  for (int i = o.shard - 1; i < trials; i += o.shards)
    if (!have.contains(i)) to_do.push_back(i);
  Appender file;
  if (auto ok = file.open(e, campaign, o.out); !ok) return tl::unexpected(ok.error());

  const hal::SteadyClock clock;
  const hal::Timestamp start = clock.now();
  std::atomic<std::size_t> next{0};
  std::atomic<bool> stop{false};
  std::mutex mutex;
  int done = 0;
  bool disk_full = false;
  const auto work = [&] {
    while (!stop) {
      const std::size_t mine = next++;
      if (mine >= to_do.size()) return;
      std::vector<Row> rows, details;
      std::string words;
      for (const control::Method method : list(o.methods)) {
        TrialRows result = e.run({o.seed, to_do[mine], method, o.view});
        const Row key{std::to_string(to_do[mine]), control::to_string(method)};
        result.row.insert(result.row.begin(), key.begin(), key.end());
        rows.push_back(std::move(result.row));
        for (Row& row : result.details) {
          row.insert(row.begin(), key.begin(), key.end());
          details.push_back(std::move(row));
        }
        if (!words.empty()) words += "; ";
        words += o.methods == Methods::Both ? fmt::format("{}: {}", control::to_string(method), result.words)
                                            : result.words;
        if (!result.kept) continue;
        const auto kept_as = keep_lift(
            *result.kept, method, o.out,
            fmt::format(
                "{}_trial_{}{}", e.name, to_do[mine],
                method == control::Method::Fast ? "" : fmt::format("_{}", control::to_string(method))));
        words += kept_as ? "; kept as " + kept_as->string() : "; not kept: " + kept_as.error().text();
      }
      const std::lock_guard lock(mutex);
      if (!file.add(rows, details)) disk_full = stop = true;
      for (Row& row : rows) campaign.trials.add(std::move(row));
      for (Row& row : details) campaign.details.add(std::move(row));
      ++done;
      if (hooks.progress) {
        const double each_s = hal::seconds(clock.now() - start) / done;
        const int left = static_cast<int>(to_do.size()) - done;
        hooks.progress({done, static_cast<int>(to_do.size()), static_cast<int>(have.size()), each_s * left,
                        fmt::format("trial {}: {}", to_do[mine], words)});
      }
      if (hooks.interrupted && hooks.interrupted()) stop = true;
    }
  };
  const int cores = std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
  const int jobs = e.times_computing
                       ? 1
                       : std::min(o.jobs > 0 ? o.jobs : cores, std::max(1, static_cast<int>(to_do.size())));
  std::vector<std::thread> others;
  for (int i = 1; i < jobs; ++i) others.emplace_back(work);
  work();
  for (std::thread& t : others) t.join();
  file.close();
  if (disk_full)
    return hal::failure(ErrorCode::BadInput, o.out.string(), "a row could not be written: is the disk full?");
  campaign.complete = done == static_cast<int>(to_do.size());
  if (auto ok = write_tables(e, campaign, o.out); !ok) return tl::unexpected(ok.error());
  return kept;
}

hal::Result<Campaign> read_campaign(const Experiment& e, const fs::path& folder) {
  auto trials = TrialTable::read(trials_file(e, folder));
  if (!trials) return tl::unexpected(trials.error());
  if (trials->columns() != with_key(e.columns))
    return hal::failure(ErrorCode::BadInput, trials_file(e, folder).string() + ":2",
                        "has other columns than this program writes; choose another --out or remove it");
  Campaign campaign{std::move(*trials), TrialTable("", with_key(e.detail_columns)), true};
  if (e.detail_columns.empty()) return campaign;
  auto details = TrialTable::read(details_file(e, folder));
  if (!details) return tl::unexpected(details.error());
  if (details->columns() != with_key(e.detail_columns) || details->header() != campaign.trials.header())
    return hal::failure(ErrorCode::BadInput, details_file(e, folder).string() + ":1",
                        "does not belong to the table of trials beside it");
  campaign.details = std::move(*details);
  // what was written for trials that were never finished
  const std::set<int> whole = trials_in(campaign.trials);
  campaign.details.erase_if_trial([&](int trial) { return !whole.contains(trial); });
  return campaign;
}

hal::Result<Campaign> merge_campaigns(const Experiment& e, const std::vector<fs::path>& from,
                                      const fs::path& out) {
  std::optional<Campaign> all;
  std::map<int, std::string> seen;
  for (const fs::path& folder : from) {
    std::error_code ignored;
    if (!fs::exists(trials_file(e, folder), ignored)) continue;
    auto part = read_campaign(e, folder);
    if (!part) return part;
    if (!all) all = empty_campaign(e, part->trials.header());
    if (part->trials.header() != all->trials.header())
      return hal::failure(
          ErrorCode::BadInput, trials_file(e, folder).string() + ":1",
          fmt::format("is \"{}\", the others are \"{}\"", part->trials.header(), all->trials.header()));
    std::map<int, std::string> here;
    for (const Row& row : part->trials.rows()) here[TrialTable::trial_of(row)] += TrialTable::line(row);
    for (const auto& [trial, text] : here) {
      const auto before = seen.find(trial);
      if (before != seen.end() && before->second != text)
        return hal::failure(ErrorCode::BadInput, trials_file(e, folder).string(),
                            fmt::format("trial {} has another result than in a folder before", trial));
    }
    for (const Row& row : part->trials.rows())
      if (!seen.contains(TrialTable::trial_of(row))) all->trials.add(row);
    for (const Row& row : part->details.rows())
      if (!seen.contains(TrialTable::trial_of(row))) all->details.add(row);
    seen.merge(here);
  }
  if (!all) return hal::failure(ErrorCode::BadInput, "merge", fmt::format("no folder holds {}.csv", e.name));
  std::error_code error;
  fs::create_directories(out, error);
  if (auto ok = write_tables(e, *all, out); !ok) return tl::unexpected(ok.error());
  return *all;
}

Campaign of_method(const Campaign& campaign, const std::string& method) {
  const auto filtered = [&](const TrialTable& table) {
    TrialTable out(table.header(), table.columns());
    for (const Row& row : table.rows())
      if (table.text(row, "method") == method) out.add(row);
    return out;
  };
  return {filtered(campaign.trials), filtered(campaign.details), campaign.complete};
}

std::optional<std::string> header_value(const Campaign& campaign, const std::string& name) {
  std::istringstream words(campaign.trials.header());
  for (std::string word; words >> word;)
    if (word.starts_with(name + "=")) return word.substr(name.size() + 1);
  return std::nullopt;
}

std::vector<std::string> methods_of(const Campaign& campaign) {
  std::vector<std::string> found;
  for (const char* method : {"fast", "thesis"})
    for (const Row& row : campaign.trials.rows())
      if (campaign.trials.text(row, "method") == method) {
        found.emplace_back(method);
        break;
      }
  return found;
}

}  // namespace colift::experiments
