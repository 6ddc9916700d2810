#include "control/session/scene_analysis.hpp"

#include <fmt/format.h>

#include <cmath>

#include "control/session/pipeline.hpp"
#include "control/session/stopwatch.hpp"

namespace colift::control {

hal::Result<SceneAnalysis> analyse_scene(SceneAnalysisInput input, Method method, const Config& c,
                                         const planner::HandModel& hand, const hal::Clock& clock,
                                         const std::shared_ptr<const planner::HandCollision>& hand_tables) {
  const auto pipeline = make_pipeline(method);
  if (!pipeline) return tl::unexpected(pipeline.error());
  SceneAnalysis out;
  out.method = method;
  out.base_frame_known = input.base_frame_known;
  Stopwatch whole(clock), watch(clock);
  (*pipeline)->analyse(input, c, watch, out);
  if (out.scene.target) {
    const perception::OrganisedCloud* const around =
        (*pipeline)->judges_surroundings() ? &out.cloud : nullptr;
    out.finder =
        std::make_shared<planner::CandidateFinder>(out.scene, around, hand, c.candidates, hand_tables);
    out.candidates = out.finder->find();
    out.ms.candidates = watch.lap();
    out.reason = planner::explain(out.candidates);
  } else {
    out.reason = out.scene.reason;
  }
  out.ms.total = whole.lap();
  out.frame = std::move(input.frame);
  return out;
}

namespace {

// a grasp has finite numbers, near the object, and two perpendicular unit vectors
std::string defect_of(const planner::GraspCandidate& c) {
  constexpr double kUnit = 1e-3, kFarthest_m = 100.0, kWidest_m = 1.0;
  if (!c.position.allFinite() || !c.approach.allFinite() || !c.closing.allFinite() ||
      !std::isfinite(c.depth_m) || !std::isfinite(c.width))
    return "is no grasp: a number is not finite";
  if (c.position.norm() > kFarthest_m)
    return fmt::format("is no grasp: its position is more than {:.0f} m away", kFarthest_m);
  if (c.width < 0.0 || c.width > kWidest_m || c.depth_m < 0.0 || c.depth_m > kWidest_m)
    return fmt::format("is no grasp: width and depth have to be 0 to {:.0f} m", kWidest_m);
  if (std::abs(c.approach.norm() - 1.0) > kUnit || std::abs(c.closing.norm() - 1.0) > kUnit)
    return "is no grasp: approach and closing have to be unit vectors";
  if (std::abs(c.approach.dot(c.closing)) > kUnit)
    return "is no grasp: closing has to be perpendicular to approach";
  return "";
}

}  // namespace

void use_candidates(SceneAnalysis& analysis, std::vector<planner::GraspCandidate> candidates) {
  const auto surfaces = static_cast<int>(analysis.scene.surfaces.size());
  int id = 0;
  for (planner::GraspCandidate& c : candidates) {
    c.id = id++;
    if (c.surface < 0 || c.surface >= surfaces) c.surface = -1;
    c.verdict = planner::Verdict::Ok;
    c.reason = defect_of(c);
    c.miss_m.reset();
    if (!c.reason.empty())
      c.verdict = planner::Verdict::Unreachable;
    else
      analysis.finder->judge(c);
  }
  analysis.candidates = std::move(candidates);
  analysis.own_candidates = true;
  analysis.reason = planner::explain(analysis.candidates);
}

}  // namespace colift::control
