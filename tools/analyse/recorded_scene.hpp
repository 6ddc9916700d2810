#pragma once

#include <filesystem>
#include <optional>

#include "control/session/scene_analysis.hpp"
#include "hal/drivers/recorded/frame_file.hpp"
#include "hal/types/result.hpp"
#include "tools/cli/options.hpp"
#include "tools/cli/session.hpp"

namespace colift::tools {

/// A frame that was looked at.
struct Seen {
  hal::RecordedFrame file;  ///< Its frame has moved into the look.
  hal::Pose X_WF = hal::Pose::Identity();
  control::SceneAnalysis analysis;
};

/// Reads and looks. Errors: BadInput and BadConfig.
[[nodiscard]] hal::Result<Seen> look_at_file(const LookOptions& options, const Setup& setup);

/// The depth of a recorded frame alone. Errors: BadInput.
[[nodiscard]] hal::Result<hal::DepthFrame> read_depth(const std::filesystem::path& file,
                                                      const std::optional<std::filesystem::path>& camera);

}  // namespace colift::tools
