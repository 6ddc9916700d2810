#pragma once

#include <memory>

#include "hal/depth_camera.hpp"
#include "hal/drivers/v4l2_camera/v4l2_camera_config.hpp"
#include "hal/drivers/v4l2_camera/z16_image.hpp"
#include "hal/types/result.hpp"

namespace colift::tools {

/// What `v4l2.intrinsics` says of the camera, with the depth unit that the robot file puts in its place.
/// Errors: BadConfig (none is named, it is missing or wrong, it has no size).
[[nodiscard]] hal::Result<hal::v4l2::DepthModel> depth_model(const hal::V4l2CameraConfig& config);

/// The camera on this machine's kernel, without a guard. The clock outlives it. Errors: those of the model.
[[nodiscard]] hal::Result<std::unique_ptr<hal::DepthCamera>> make_video_camera(
    const hal::V4l2CameraConfig& config, const hal::Clock& clock);

}  // namespace colift::tools
