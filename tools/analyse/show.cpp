#include "tools/analyse/show.hpp"

#include <fmt/format.h>

#include "tools/analyse/grasp_rows.hpp"
#include "tools/analyse/words.hpp"
#include "tools/visualization/report/report.hpp"
#include "tools/visualization/scene/scene_picture.hpp"

namespace colift::tools {
namespace {

picture::ScenePicture picture_of(const Seen& seen, const control::Outcome* outcome,
                                 const planner::HandModel& hand) {
  picture::ScenePicture p;
  const control::SceneAnalysis& l = seen.analysis;
  p.cloud = &l.cloud;
  p.rgb = &l.frame.rgb;
  p.scene = &l.scene;
  p.candidates = outcome ? &outcome->candidates : &l.candidates;
  p.hand_opening_m = hand.opening_m;
  p.palm_gap_m = hand.palm_gap_m;
  p.reason = outcome ? outcome->decision.reason : l.reason;
  p.figures.emplace_back("method", control::to_string(l.method));
  p.figures.emplace_back("look", fmt::format("{:.1f} ms", l.ms.total));
  if (outcome) {
    p.figures.emplace_back("decision", fmt::format("{:.2f} ms", outcome->decision_ms));
    p.partner = outcome->partner;
    p.partner_pixels = outcome->partner_pixels;
    if (outcome->decision.chosen) {
      p.share = outcome->decision.share;
      p.optimum = outcome->decision.optimum;
    }
    p.notes.push_back(outcome->partner_reason);
  }
  if (l.scene.target) p.notes.push_back(l.scene.target->reason);
  p.notes.push_back(seen.file.note);
  return p;
}

picture::Report report_of(const Seen& seen, const control::Outcome* outcome, const CommonOptions& common,
                          const Setup& setup, const picture::ScenePicture& picture) {
  const control::SceneAnalysis& l = seen.analysis;
  picture::Report r;
  r.title = picture.title;
  r.summary.push_back(picture.reason);
  r.notes = picture.notes;
  r.pictures.push_back(
      {picture::scene_picture_png(picture), "What was seen in the frame and what was decided."});
  r.candidates = outcome ? candidate_rows(outcome->candidates, outcome->decision.scores)
                         : candidate_rows(l.candidates, {});
  for (const auto& s : l.scene.surfaces) r.surfaces.push_back(surface_line(s));
  r.timing = {{"ground", l.ms.ground},
              {"target", l.ms.target},
              {"surfaces", l.ms.surfaces},
              {"candidates", l.ms.candidates}};
  if (outcome) {
    r.timing.push_back({"partner", outcome->partner_ms});
    r.timing.push_back({"decision", outcome->decision_ms});
    if (!outcome->share.text.empty()) {
      if (!outcome->share.wanted) r.notes.push_back(outcome->share.text);
      r.notes.push_back(outcome->share.partner_text);
      if (outcome->share.certificate) r.notes.push_back(outcome->share.certificate->text);
    }
  }
  r.facts = picture.figures;
  r.facts.emplace_back("points seen", fmt::format("{} of {}", seen.file.valid_points, seen.file.points));
  r.command = common.command;

  r.config.assign(setup.origins.begin(), setup.origins.end());
  return r;
}

}  // namespace

hal::Result<> show(const Seen& seen, const control::Outcome* outcome, const LookOptions& options,
                   const CommonOptions& common, const Setup& setup) {
  if (!options.png && !options.report) return {};
  picture::ScenePicture picture = picture_of(seen, outcome, setup.hand);
  picture.title = options.cloud.parent_path().filename().string() + "/" + options.cloud.filename().string();
  if (options.png) {
    if (auto written = picture::write_scene_picture(*options.png, picture); !written) return written;
    if (!common.quiet) fmt::print(stderr, "picture: {}\n", options.png->string());
  }
  if (options.report) {
    if (auto written =
            picture::write_report(*options.report, report_of(seen, outcome, common, setup, picture));
        !written)
      return written;
    if (!common.quiet) fmt::print(stderr, "report: {}\n", options.report->string());
  }
  return {};
}

}  // namespace colift::tools
