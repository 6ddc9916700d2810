#include "tools/experiments/worst.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <optional>
#include <vector>

#include "control/task/run_record.hpp"
#include "tools/experiments/campaign.hpp"
#include "tools/visualization/file_output.hpp"
#include "tools/visualization/report/report_parts.hpp"
#include "tools/visualization/scene/scene_picture.hpp"

namespace colift::experiments {
namespace {

struct Ranked {
  int trial = 0;
  std::string method;
  Badness badness;
  Row row;
};

std::vector<Ranked> ranked(const Experiment& e, const Campaign& campaign) {
  std::vector<Ranked> all;
  for (const std::string& method : methods_of(campaign)) {
    const Campaign mine = of_method(campaign, method);
    const Results results{mine.trials, mine.details};
    for (const Row& row : mine.trials.rows())
      if (auto badness = e.badness(results, row))
        all.push_back({TrialTable::trial_of(row), method, *std::move(badness), row});
  }
  std::stable_sort(all.begin(), all.end(),
                   [](const Ranked& a, const Ranked& b) { return a.badness.value > b.badness.value; });
  return all;
}

// what the camera saw when the grasp was chosen, with all that was found and believed
std::optional<picture::ReportPicture> picture_of(const control::RunRecord& record,
                                                 const std::string& caption) {
  if (!record.analysis) return std::nullopt;
  const control::SceneAnalysis& a = *record.analysis;
  picture::ScenePicture p;
  p.cloud = &a.cloud;
  p.scene = &a.scene;
  p.candidates = record.decision ? &record.decision->candidates : &a.candidates;
  p.title = caption;
  p.reason = record.reason;
  if (record.decision) {
    p.partner = record.decision->partner;
    p.optimum = record.decision->decision.optimum;
    if (record.decision->decision.chosen) p.share = record.decision->decision.share;
    if (record.decision->share.certificate) p.notes.push_back(record.decision->share.certificate->text);
  }
  return picture::ReportPicture{picture::draw_scene_picture(p).png(), caption};
}

std::string facts(const Experiment& e, const Row& row) {
  std::string text;
  for (std::size_t i = 0; i < e.columns.size() && i + 2 < row.size(); ++i)
    if (!row[i + 2].empty())
      text += fmt::format("{}{} {}", text.empty() ? "" : ", ", e.columns[i], row[i + 2]);
  return text;
}

}  // namespace

hal::Result<std::filesystem::path> write_worst(const Experiment& e, const WorstOptions& options,
                                               const std::function<bool(const std::string&)>& progress) {
  const auto refuse = [&](std::string where, std::string why) {
    return hal::failure(hal::ErrorCode::BadInput, std::move(where), std::move(why));
  };
  if (!e.badness) return refuse(e.name, "does not rank its trials; mass, share and certificate do");
  const auto campaign = read_campaign(e, options.folder);
  if (!campaign) return tl::unexpected(campaign.error());
  Trial trial;
  const std::string seed = header_value(*campaign, "seed").value_or("");
  if (std::from_chars(seed.data(), seed.data() + seed.size(), trial.seed).ec != std::errc())
    return refuse(options.folder.string(), "its table does not say its seed");
  trial.view = header_value(*campaign, "camera") == "side" ? View::Side : View::OfLayout;
  std::vector<Ranked> worst = ranked(e, *campaign);
  if (worst.empty()) return refuse(options.folder.string(), "no trial there has anything against it");
  const std::size_t of = worst.size();
  worst.resize(std::min(of, static_cast<std::size_t>(std::max(1, options.count))));

  std::string body = picture::report_paragraphs(
      {e.question,
       fmt::format("The worst {} of {} trials that have something against them, made once more. {}.",
                   worst.size(), of, campaign->trials.header())});
  int number = 0;
  for (const Ranked& w : worst) {
    ++number;
    std::vector<picture::ReportPicture> pictures;
    std::vector<std::string> sentences{w.badness.words};
    trial.index = w.trial;
    trial.method = control::method_named(w.method).value_or(control::Method::Fast);
    trial.watch = [&](const control::RunRecord& record) {
      sentences.push_back(record.reason);
      if (auto p = picture_of(record, fmt::format("trial {}, {}", w.trial, w.method)))
        pictures.push_back(*std::move(p));
    };
    const TrialRows again = e.run(trial);
    sentences.push_back(again.words);
    sentences.push_back(facts(e, w.row));
    body += picture::report_heading(fmt::format("{}. trial {}, {}", number, w.trial, w.method));
    body += picture::report_paragraphs(sentences);
    body += picture::report_figures(pictures);
    const bool on = progress(
        fmt::format("{} {}/{}: trial {}: {}", e.name, number, worst.size(), w.trial, w.badness.words));
    if (!on) break;
  }
  const std::string page =
      picture::report_page("CoLift: worst trials of " + e.name, "", picture::ReportTone::Plain, body);
  const std::filesystem::path file = options.folder / (e.name + "_worst.html");
  if (auto ok = picture::write_file(file, {reinterpret_cast<const std::uint8_t*>(page.data()), page.size()});
      !ok)
    return tl::unexpected(ok.error());
  return file;
}

}  // namespace colift::experiments
