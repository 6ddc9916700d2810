#pragma once

#include <string>

#include "hal/depth_camera.hpp"
#include "hal/types/time.hpp"
#include "perception/noise_model.hpp"
#include "tools/bring_up/cmd_hal_camera.hpp"

namespace colift::tools {

/// What a depth camera of any kind can be asked for. Errors: BadInput (the verb or option needs a Kinect).
[[nodiscard]] hal::Result<> check_depth_camera_request(const HalCameraOptions& options);

/// info, watch and noise for a depth camera that is not open yet; `source` names it, `advice` says what to do
/// when it cannot be opened. 0 done, 2 bad request or file, 3 the camera is not there or went away, 130
/// interrupted.
[[nodiscard]] int watch_depth_camera(const CommonOptions& common, const HalCameraOptions& options,
                                     const std::string& source, const std::string& advice,
                                     hal::DepthCamera& camera, const hal::Clock& clock, double for_s,
                                     const perception::NoiseModel& configured);

}  // namespace colift::tools
