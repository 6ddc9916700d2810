#pragma once

#include <functional>
#include <memory>

#include "hal/depth_camera.hpp"
#include "hal/drivers/ros2_camera/ros2_camera_config.hpp"
#include "hal/guards/guarded_camera.hpp"
#include "hal/types/result.hpp"
#include "sim_hal/emulator/served_camera.hpp"
#include "sim_hal/mujoco/sim_world.hpp"

namespace colift::tools {

/// A camera over ROS 2 behind its guard. The clock outlives it. Errors: BadConfig where the program was built
/// without Cyclone DDS.
[[nodiscard]] hal::Result<std::unique_ptr<hal::DepthCamera>> make_ros2_camera(
    const hal::Ros2CameraConfig& config, const hal::CameraGuardConfig& guard, const hal::Clock& clock);

/// Serves the scenario's camera in a world on the topics that the driver is to read, with the scenario's
/// faults of the camera. Errors: BadConfig (a fault that is none, `time: clock`, no Cyclone DDS),
/// DeviceFault.
[[nodiscard]] std::function<hal::Result<std::unique_ptr<sim_hal::ServedCamera>>(const sim_hal::SimWorld&)>
emulated_ros2_camera(const hal::Ros2CameraConfig& config);

}  // namespace colift::tools
