#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "hal/device.hpp"
#include "hal/drivers/kinect/kinect_camera.hpp"

namespace colift::tools {

/// All that is said about the camera at one moment.
struct CameraView {
  std::string source;
  hal::DeviceHealth health;
  hal::KinectReport report;
  std::optional<hal::Vec3> up_C;
  double near_m = 0.0, middle_m = 0.0, far_m = 0.0;  ///< Of the pixels that see: 2 %, 50 %, 98 %.
  double at_s = 0.0;
};
/// Takes nearest, middle and farthest depth and gravity of a frame over.
void look_at_frame(const hal::DepthFrame& frame, CameraView& view);

/// One screen: device, process, frames, what is seen.
[[nodiscard]] std::string camera_screen(const CameraView& view);
/// One line of it.
[[nodiscard]] std::string camera_line(const CameraView& view);
/// Document colift.hal.camera/1.
[[nodiscard]] std::string camera_document(const std::string& verb, const CameraView& view,
                                          const std::string& end, const std::string& reason);
/// What to do about an error of the start.
[[nodiscard]] std::string camera_advice(hal::ErrorCode code, const std::string& source);

/// The frame as a picture, lit, with what it shows in a line beneath. Errors: BadInput (cannot be written).
[[nodiscard]] hal::Result<> write_camera_picture(const std::filesystem::path& png,
                                                 const hal::DepthFrame& frame, const CameraView& view);

}  // namespace colift::tools
