#pragma once

#include <filesystem>
#include <functional>
#include <string>

#include "hal/drivers/openni2_camera/openni2_config.hpp"
#include "tools/doctor/doctor_row.hpp"

namespace colift::tools {

/// What the capture process said when it was asked about its library.
struct CaptureAnswer {
  bool fine = false;
  std::string words;  ///< Its last line, or how it ended.
};
using AskCapture = std::function<CaptureAnswer(const std::filesystem::path& program)>;

/// Starts the capture process with --probe, which opens no device; no longer than 2 s.
[[nodiscard]] CaptureAnswer ask_capture(const std::filesystem::path& program);

/// The program beside this one that reads the Kinect, and whether it starts with its library. `wanted`: the
/// robot has a Kinect, so that it is bad without.
[[nodiscard]] DoctorRows capture_rows(const std::filesystem::path& program, bool wanted,
                                      const AskCapture& ask);

/// The same for a camera of OpenNI2 with the devices that OpenNI2 finds, as this robot reaches it.
[[nodiscard]] DoctorRows openni2_rows(const hal::Openni2CameraConfig& config);

}  // namespace colift::tools
