#pragma once

#include <string>
#include <vector>

#include "control/config/method.hpp"
#include "hal/types/result.hpp"
#include "tools/cli/session.hpp"
#include "tools/scenes/scene_file.hpp"
#include "tools/scenes/scene_truth.hpp"

namespace colift::tools {

/// What a method says of one step, beside the truth.
struct SceneRow {
  SceneStep step = SceneStep::Empty;
  control::Method method = control::Method::Fast;
  SceneVerdict verdict = SceneVerdict::Nothing;
  std::string truth, found;  ///< In a person's words, with numbers.
  bool accepted = false;     ///< Right, or no worse than `known` of the scene's file.
};

/// empty: no target is right. object: at least 85 % of the target's points are the object's, and 60 % of the
/// object's pixels are in it; partly: most of its points are. hand: within 10 cm of the truth, partly 20.
/// lift, with `fast` alone: followed up to the last image and risen by more than 1 cm, within 1.5 cm of what
/// was measured where it was. Errors: those of the analysis.
[[nodiscard]] hal::Result<std::vector<SceneRow>> check_scene(const RecordedSteps& scene,
                                                             const SceneTruth& truth, const Setup& setup);

}  // namespace colift::tools
