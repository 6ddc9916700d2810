#pragma once

#include <optional>

#include "hal/drivers/openni2_camera/openni2_config.hpp"
#include "hal/types/result.hpp"
#include "perception/noise_model.hpp"
#include "tools/bring_up/cmd_hal_camera.hpp"

namespace colift::tools {

/// The camera of OpenNI2 that a request means: that of the robot file, with --source in its source's place;
/// or `--source openni2:SOURCE`, which needs no file. Nothing: it means another camera, or its file is wrong.
[[nodiscard]] std::optional<hal::Openni2CameraConfig> openni2_of(const HalCameraOptions& options);

/// info, watch, noise, record of a file (.oni) or of a scene. Exit codes as watch_depth_camera().
[[nodiscard]] int openni2_command(const CommonOptions& common, const HalCameraOptions& options,
                                  const hal::Openni2CameraConfig& config, double for_s,
                                  const perception::NoiseModel& configured);

}  // namespace colift::tools
