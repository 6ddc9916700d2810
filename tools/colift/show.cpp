#include "tools/colift/show.hpp"

#include <fmt/format.h>

#include "tools/colift/words.hpp"
#include "tools/picture/scene_picture.hpp"

namespace colift::tools {
namespace {

picture::ScenePicture picture_of(const Seen& seen, const control::Outcome* outcome, const planner::HandModel& hand) {
  picture::ScenePicture p;
  const control::Look& l = seen.look;
  p.cloud = &l.cloud;
  p.rgb = &l.frame.rgb;
  p.scene = &l.scene;
  p.candidates = outcome ? &outcome->candidates : &l.candidates;
  p.hand_opening_m = hand.opening_m;
  p.palm_gap_m = hand.palm_gap_m;
  p.because = outcome ? outcome->decision.because : l.because;
  p.figures.emplace_back("method", l.method == control::Method::Fast ? "fast" : "thesis");
  p.figures.emplace_back("look", fmt::format("{:.1f} ms", l.ms.total));
  if (outcome) {
    p.figures.emplace_back("decision", fmt::format("{:.2f} ms", outcome->decision_ms));
    p.partner = outcome->partner;
    p.partner_pixels = outcome->partner_pixels;
    if (outcome->decision.chosen) {
      p.share = outcome->decision.share;
      p.optimum = outcome->decision.optimum;
    }
    p.notes.push_back(outcome->partner_because);
  }
  if (l.scene.target) p.notes.push_back(l.scene.target->because);
  p.notes.push_back(seen.file.note);
  return p;
}

}  // namespace

hal::Result<> show(const Seen& seen, const control::Outcome* outcome, const LookOptions& options,
                   const CommonOptions& common, const planner::HandModel& hand) {
  if (!options.png && !options.report) return {};
  picture::ScenePicture picture = picture_of(seen, outcome, hand);
  picture.title = options.cloud.parent_path().filename().string() + "/" + options.cloud.filename().string();
  if (options.png) {
    if (auto written = picture::write_scene_picture(*options.png, picture); !written) return written;
    if (!common.quiet) fmt::print(stderr, "picture: {}\n", options.png->string());
  }
  return {};
}

}  // namespace colift::tools
