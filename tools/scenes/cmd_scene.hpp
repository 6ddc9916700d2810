#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "tools/cli/options.hpp"
#include "tools/scenes/scene_words.hpp"

namespace colift::tools {

struct SceneOptions {
  std::vector<std::filesystem::path> folders;  ///< Recorded scenes, or folders of them.
  std::string method;                          ///< "fast", "thesis" or "both"; empty: as configured.
  std::optional<std::filesystem::path> png;    ///< Picture of the truth, of one scene.
};

/// What look, decide and the object follower say of recorded scenes, beside the truth of their differences. 0
/// every answer is right or known, 1 one is not, or a scene has no truth, 2 bad file or configuration.
[[nodiscard]] int cmd_scene(const CommonOptions& common, const SceneOptions& options);

/// The same for one scene and the methods named. Errors: BadInput and BadConfig.
[[nodiscard]] hal::Result<CheckedScene> check_recorded_scene(const CommonOptions& common,
                                                             const std::filesystem::path& folder,
                                                             const std::string& method,
                                                             const std::optional<std::filesystem::path>& png);

}  // namespace colift::tools
