#pragma once

#include <memory>

#include "hal/depth_camera.hpp"
#include "hal/drivers/ros2_camera/ros2_camera_config.hpp"

namespace colift::hal {

/// Any depth camera with a driver for ROS 2 as a DepthCamera, over DDS. One thread; Cyclone DDS receives in
/// its own.
///
/// Everything that comes is checked (ros2_image.hpp); what is wrong is dropped, counted and described in
/// health(). It stays with the publisher of its first frame as long as that is there: another one on the same
/// topic is not listened to. A camera model that changes while frames are taken is an error, not a new model.
/// After a LinkLost frames come again by themselves.
class Ros2Camera final : public DepthCamera {
 public:
  /// The clock has to outlive the camera; it is the one of the frames' time stamps, and runs as the system's
  /// does.
  Ros2Camera(Ros2CameraConfig config, const Clock& clock);
  ~Ros2Camera() override;

  /// The first time waits for a frame, up to `open_s`. Errors: BadConfig (topic, domain, interface), LinkLost
  /// (nobody publishes), DeviceFault (what comes cannot be used; more than one publisher).
  [[nodiscard]] Result<> configure() override;
  [[nodiscard]] Result<> activate() override;
  void deactivate() noexcept override;
  [[nodiscard]] DeviceHealth health() const override;
  [[nodiscard]] Result<DepthFrame> next_frame(std::chrono::milliseconds timeout) override;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace colift::hal
