#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>

#include "hal/depth_camera.hpp"
#include "hal/types/result.hpp"
#include "hal/types/time.hpp"
#include "tools/bring_up/cmd_hal_camera.hpp"
#include "tools/scenes/scene_file.hpp"

namespace colift::tools {

/// What is recorded, beside the pictures.
struct SceneRequest {
  std::filesystem::path folder;  ///< New or empty.
  std::string object, camera, licence;
  std::optional<double> lifted_m;
  double lift_s = 4.0;  ///< Duration of the last step.
};

/// Says what to do before a step and returns when it may be recorded; an error ends the recording.
using AskStep = std::function<hal::Result<>(SceneStep step, const std::string& words)>;

/// Records the four steps: five images of each, of the lift ten, as 16-bit PNG (mm) with camera.json and
/// scene.json. What was exposed before a step may be recorded is left out. The camera is configured and
/// activated here. What was not recorded to its end is removed. Errors: BadInput (folder, disk, or of `ask`),
/// Timeout (no image for 3 s), and the camera's.
[[nodiscard]] hal::Result<SceneFile> record_scene(hal::DepthCamera& camera, const hal::Clock& clock,
                                                  const SceneRequest& request, const AskStep& ask);

/// The same, asked at the terminal (Enter, or by itself after `--pause`), then checked as `colift scene`
/// does. 0 recorded, 1 recorded but its truth cannot be told, 2 bad request or file, 3 the camera is not
/// there or went away, 130 interrupted.
[[nodiscard]] int cmd_record_scene(const CommonOptions& common, const HalCameraOptions& options,
                                   const std::string& source, const std::string& advice,
                                   hal::DepthCamera& camera, const hal::Clock& clock);

}  // namespace colift::tools
