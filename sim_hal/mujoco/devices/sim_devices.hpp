#pragma once

#include "hal/robot.hpp"
#include "sim_hal/mujoco/sim_world.hpp"

namespace colift::sim_hal {

/// Arm, hand and camera on one world, with the scenario's faults. Whoever waits on a device moves the world:
/// wait_cycle() by one arm period, next_frame(timeout) up to the next exposure, and not at all when a frame
/// is already due or timeout is zero. Frames come at 30 Hz; a frame shows the world as it is when it is
/// asked for. One thread. The world has to outlive the devices.
[[nodiscard]] std::unique_ptr<hal::Arm> make_sim_arm(SimWorld& world);
[[nodiscard]] std::unique_ptr<hal::Hand> make_sim_hand(SimWorld& world);
[[nodiscard]] std::unique_ptr<hal::DepthCamera> make_sim_camera(SimWorld& world);
/// Those of the scenario's more_cameras, in their order.
[[nodiscard]] std::vector<std::unique_ptr<hal::DepthCamera>> make_more_sim_cameras(SimWorld& world);
/// The world's time, as a robot's clock.
[[nodiscard]] std::unique_ptr<hal::Clock> make_sim_clock(const SimWorld& world);

/// Pose of the camera in W as the scenario says.
[[nodiscard]] Pose camera_pose(const ScenarioCamera& camera);
/// The same of its more_cameras.
[[nodiscard]] std::vector<Pose> more_camera_poses(const Scenario& scenario);

}  // namespace colift::sim_hal
