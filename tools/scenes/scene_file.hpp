#pragma once

#include <array>
#include <filesystem>
#include <vector>

#include "hal/depth_camera.hpp"
#include "hal/types/result.hpp"
#include "tools/scenes/scene_json.hpp"

namespace colift::tools {

/// A folder that `colift hal camera record --scene` wrote.
struct RecordedSteps {
  std::filesystem::path folder;
  SceneFile file;
  std::array<std::vector<hal::DepthFrame>, 4> frames;  ///< By step.
};

/// Errors: BadInput (scene.json or an image is missing, is none, or a step has no image; images of different
/// sizes), with the place.
[[nodiscard]] hal::Result<RecordedSteps> read_scene(const std::filesystem::path& folder);

/// Writes scene.json into the folder. Errors: BadInput with the path.
[[nodiscard]] hal::Result<> write_scene_file(const std::filesystem::path& folder, const SceneFile& file);

}  // namespace colift::tools
