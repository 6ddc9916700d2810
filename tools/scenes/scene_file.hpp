#pragma once

#include <array>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "hal/depth_camera.hpp"
#include "hal/types/result.hpp"

namespace colift::tools {

/// What a fixed camera watches, in this order: the place without the object, with it, with a person who has
/// taken hold of it, and how it is lifted.
enum class SceneStep { Empty, Object, Hand, Lift };
inline constexpr std::array kSceneSteps{SceneStep::Empty, SceneStep::Object, SceneStep::Hand,
                                        SceneStep::Lift};
[[nodiscard]] const char* to_string(SceneStep step);

/// How good an answer is, from best to worst.
enum class SceneVerdict {
  Right,
  Partly,
  Nothing,
  Wrong,
};
[[nodiscard]] const char* to_string(SceneVerdict verdict);

/// scene.json: what no picture shows, and which pictures there are. `schema` is colift.scene/1.
struct SceneFile {
  std::string name;                ///< One line of a table.
  std::string object;              ///< What is carried, in a person's words.
  std::string camera;              ///< Driver and source.
  std::string licence;             ///< Under which others may have the pictures; may be empty.
  std::optional<double> lifted_m;  ///< How far it was lifted in the end, where it was measured.
  std::array<std::vector<std::string>, 4> images;  ///< By step, in the order of time; in the folder.
  std::map<std::string, SceneVerdict> known;       ///< By step: a verdict that is no better yet.
};

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
