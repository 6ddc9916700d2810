#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "tools/emulate/emulate.hpp"

namespace colift::tools {

struct EmulateCameraOptions {
  EmulateOptions common;
  std::optional<std::filesystem::path> fakenect;  ///< Writes a recording there instead of serving live.
  bool live = false;
  std::string address = "@colift-kinect";  ///< Of the live camera.
};

/// A Kinect on a simulated world: live behind libfreenect's own functions, or as a recording for fakenect. 0
/// done, 2 bad options, 3 the address is not to be had.
[[nodiscard]] int cmd_emulate_camera(const CommonOptions& common, const EmulateCameraOptions& options);

}  // namespace colift::tools
