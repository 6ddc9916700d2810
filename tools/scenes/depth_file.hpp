#pragma once

#include <filesystem>

#include "hal/depth_camera.hpp"
#include "hal/types/result.hpp"

namespace colift::tools {

/// A frame as `look`, `decide` and `check` read it: 16-bit PNG in millimetres, camera.json beside it. Errors:
/// BadInput (cannot be written).
[[nodiscard]] hal::Result<> write_depth(const std::filesystem::path& png, const hal::DepthFrame& frame);

}  // namespace colift::tools
