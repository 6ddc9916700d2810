#pragma once

#include <memory>

#include "hal/drivers/openni2_camera/openni2_camera.hpp"
#include "hal/types/result.hpp"

namespace colift::tools {

/// The camera with the intrinsics that its file names, without a guard. The clock outlives it. Errors:
/// BadConfig (the file is missing or wrong, has no size, or another one than the configuration asks for).
[[nodiscard]] hal::Result<std::unique_ptr<hal::Openni2Camera>> make_openni2_camera(
    hal::Openni2CameraConfig config, const hal::Clock& clock);

}  // namespace colift::tools
