#pragma once

#include <array>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

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
  std::optional<std::array<double, 2>>
      hand_px;  ///< The hand in the third step's images, where one has to be told.
  std::array<std::vector<std::string>, 4> images;  ///< By step, in the order of time; in the folder.
  std::map<std::string, SceneVerdict> known;       ///< By step: a verdict that is no better yet.
};

/// Errors: BadInput with `place` and what is wrong there.
[[nodiscard]] hal::Result<SceneFile> parse_scene_file(std::string_view text, const std::string& place);

/// What parse_scene_file() reads.
[[nodiscard]] std::string scene_file_text(const SceneFile& file);

}  // namespace colift::tools
