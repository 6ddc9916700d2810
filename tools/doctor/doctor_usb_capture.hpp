#pragma once

#include <filesystem>
#include <functional>
#include <string>

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

}  // namespace colift::tools
