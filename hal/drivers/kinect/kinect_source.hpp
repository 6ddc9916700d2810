#pragma once

#include <string>

#include "hal/drivers/capture_link/capture_process.hpp"
#include "hal/drivers/kinect/kinect_config.hpp"

namespace colift::hal::kinect {

/// Where frames come from, as `source` says it.
struct KinectSource {
  enum class Kind { Usb, Fakenect, Emulated };
  Kind kind = Kind::Usb;
  std::string what;  ///< Serial number, folder, address.
  capture::CaptureCall call;
};

/// Reads `source` and finds what it needs: the capture process, Debian's fakenect library, the emulator's
/// library. Errors: BadConfig, with what was looked for and where.
[[nodiscard]] Result<KinectSource> kinect_source(const KinectConfig& config);

}  // namespace colift::hal::kinect
