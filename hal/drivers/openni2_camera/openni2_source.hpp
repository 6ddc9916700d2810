#pragma once

#include <optional>
#include <string>

#include "hal/drivers/capture_link/capture_process.hpp"
#include "hal/drivers/openni2_camera/openni2_config.hpp"

namespace colift::hal::openni2 {

/// Where frames come from, as `source` says it.
struct Source {
  enum class Kind { Device, File, Emulated };
  Kind kind = Kind::Device;
  capture::CaptureCall call;
};

/// Reads `source` and finds what it needs: the capture process, a recording, the emulator's folder of
/// drivers. Errors: BadConfig, with what was looked for and where.
[[nodiscard]] Result<Source> find_source(const Openni2CameraConfig& config);

}  // namespace colift::hal::openni2
