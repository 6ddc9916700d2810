#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "tools/bring_up/cmd_hal.hpp"

namespace colift::tools {

struct HalCameraOptions {
  HalOptions hal;
  std::string source;                          ///< In place of the robot file's kinect.source; empty: that.
  std::optional<std::filesystem::path> png;    ///< Picture of one frame.
  std::optional<std::filesystem::path> depth;  ///< The frame itself: 16-bit PNG (mm), camera.json beside it.
  std::optional<std::filesystem::path> infrared;  ///< Picture of one infrared image.
  std::optional<std::filesystem::path> out;       ///< Noise model as a configuration file.
  std::filesystem::path folder;                   ///< Of a recording; of OpenNI2 the file.
  bool scene = false;                             ///< Four steps with their truth, for a regression test.
  std::string object, licence;                    ///< Of the scene.
  std::optional<double> lifted_m;  ///< How far the object is lifted in it, where that is known.
  std::optional<double> pause_s;   ///< Before each of its steps, in place of Enter.
  double tilt_deg = 0.0;
};

/// Bring-up of the Kinect: info, watch, record, noise, tilt; of a camera of OpenNI2 all but tilt, of a video
/// device (`camera: v4l2`) info, watch, record --scene and noise. 0 done, 2 bad request or file, 3 the camera
/// is not there or went away, 130 interrupted.
[[nodiscard]] int cmd_hal_camera(const CommonOptions& common, const HalCameraOptions& options);

}  // namespace colift::tools
