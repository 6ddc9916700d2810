#pragma once

#include <functional>
#include <string>

#include "hal/depth_camera.hpp"
#include "hal/drivers/openni2_camera/openni2_camera.hpp"
#include "hal/types/time.hpp"
#include "perception/noise_model.hpp"
#include "tools/bring_up/cmd_hal_camera.hpp"

namespace colift::tools {

/// What a depth camera of any kind can be asked for, and one of OpenNI2: that one has sources, and is
/// recorded. Errors: BadInput (the verb or option needs a Kinect).
[[nodiscard]] hal::Result<> check_depth_camera_request(const HalCameraOptions& options, bool openni2 = false);

/// A depth camera that is not open yet, and what is said of it.
struct WatchedCamera {
  hal::DepthCamera& camera;
  std::string source, advice;                    ///< Its name; what to do when it cannot be opened.
  std::function<hal::Openni2Report()> report{};  ///< Of its capture process; unset: it has none.
};

/// info, watch and noise for it. 0 done, 2 bad request or file, 3 the camera is not there or went away, 130
/// interrupted.
[[nodiscard]] int watch_depth_camera(const CommonOptions& common, const HalCameraOptions& options,
                                     const WatchedCamera& watched, const hal::Clock& clock, double for_s,
                                     const perception::NoiseModel& configured);

}  // namespace colift::tools
