#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "tools/scenes/check_scene.hpp"
#include "tools/visualization/canvas.hpp"

namespace colift::tools {

/// One scene of a call: its rows, or why there are none.
struct CheckedScene {
  std::filesystem::path folder;
  SceneFile file;
  std::vector<SceneRow> rows;
  std::string reason;  ///< Empty where the truth is known.

  [[nodiscard]] bool accepted() const;
};

/// For a terminal: a line for each row.
[[nodiscard]] std::string scene_text(const CheckedScene& checked);

/// The document colift.scenes/1.
[[nodiscard]] std::string scenes_document(const std::vector<CheckedScene>& checked);

/// The truth over the depth images: the object bluish, the person reddish, a ring at the hand.
[[nodiscard]] picture::Canvas scene_picture(const RecordedSteps& scene, const SceneTruth& truth);

}  // namespace colift::tools
