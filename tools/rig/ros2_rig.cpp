#include "tools/rig/ros2_rig.hpp"

#include <utility>

#ifdef COLIFT_DDS
#include "hal/dds/ros2_names.hpp"
#include "hal/drivers/ros2_camera/ros2_camera.hpp"
#include "sim_hal/emulator/mujoco/video_world_source.hpp"
#include "sim_hal/emulator/ros2/ros2_camera_server.hpp"
#endif

namespace colift::tools {

#ifdef COLIFT_DDS
namespace {

hal::Result<std::unique_ptr<sim_hal::ServedCamera>> serve(const hal::Ros2CameraConfig& ros2,
                                                          const sim_hal::SimWorld& world) {
  if (ros2.time != "system")
    return hal::failure(hal::ErrorCode::BadConfig, "ros2.time",
                        "an emulated camera stamps with the system's time; expected system");
  auto faults = sim_hal::faults_of("camera", world.scenario().faults, {}, sim_hal::ros2_camera_fault,
                                   sim_hal::parse_ros2_camera_fault);
  if (!faults) return tl::unexpected(faults.error());
  sim_hal::Ros2CameraServerConfig config;
  const auto domain = hal::dds::domain_or_environment(ros2.domain);
  if (!domain) return tl::unexpected(domain.error());
  config.domain = *domain;
  config.interface = ros2.interface;
  config.image = ros2.image;
  config.info = ros2.info;
  if (!ros2.frame.empty()) config.frame_id = ros2.frame;
  config.faults = std::move(*faults);
  return sim_hal::Ros2CameraServer::start(
      config, std::make_unique<sim_hal::VideoWorldSource>(world, hal::CameraIntrinsics{}));
}

}  // namespace

hal::Result<std::unique_ptr<hal::DepthCamera>> make_ros2_camera(const hal::Ros2CameraConfig& config,
                                                                const hal::CameraGuardConfig& guard,
                                                                const hal::Clock& clock) {
  return std::make_unique<hal::GuardedCamera>(std::make_unique<hal::Ros2Camera>(config, clock), guard, clock);
}

std::function<hal::Result<std::unique_ptr<sim_hal::ServedCamera>>(const sim_hal::SimWorld&)>
emulated_ros2_camera(const hal::Ros2CameraConfig& config) {
  return [config](const sim_hal::SimWorld& world) { return serve(config, world); };
}
#else
namespace {

tl::unexpected<hal::Error> no_dds() {
  return hal::failure(
      hal::ErrorCode::BadConfig, "camera: ros2",
      "this program was built without Cyclone DDS; install cyclonedds-dev and cyclonedds-tools, "
      "then run tools/build");
}

}  // namespace

hal::Result<std::unique_ptr<hal::DepthCamera>> make_ros2_camera(const hal::Ros2CameraConfig&,
                                                                const hal::CameraGuardConfig&,
                                                                const hal::Clock&) {
  return no_dds();
}

std::function<hal::Result<std::unique_ptr<sim_hal::ServedCamera>>(const sim_hal::SimWorld&)>
emulated_ros2_camera(const hal::Ros2CameraConfig&) {
  return [](const sim_hal::SimWorld&) -> hal::Result<std::unique_ptr<sim_hal::ServedCamera>> {
    return no_dds();
  };
}
#endif

}  // namespace colift::tools
