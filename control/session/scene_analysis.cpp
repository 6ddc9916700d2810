#include "control/session/scene_analysis.hpp"

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

}  // namespace colift::control
