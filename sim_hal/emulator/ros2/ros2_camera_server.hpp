#pragma once

#include <memory>
#include <string>
#include <vector>

#include "hal/types/result.hpp"
#include "sim_hal/emulator/ros2/ros2_camera_faults.hpp"
#include "sim_hal/emulator/served_camera.hpp"
#include "sim_hal/emulator/video/video_source.hpp"

namespace colift::sim_hal {

/// Where a depth camera's driver of ROS 2 would publish.
struct Ros2CameraServerConfig {
  int domain = 0;
  std::string interface = "lo";  ///< Network interface; "lo": this machine alone.
  std::string image = "/camera/depth/image_rect_raw";
  std::string info = "/camera/depth/camera_info";
  std::string frame_id = "camera_depth_optical_frame";
  double rate_hz = 30.0;
  std::vector<Ros2CameraFault> faults;
};

/// The driver of a depth camera as ROS 2 has it, in front of a VideoSource: sensor_msgs/Image (16UC1, mm) and
/// CameraInfo at 30 Hz, stamped with the system's time, in a thread of its own. Only where Cyclone DDS is.
class Ros2CameraServer final : public ServedCamera {
 public:
  /// Publishes from now on. Errors: BadConfig (domain, interface, names), DeviceFault (what Cyclone DDS
  /// reports).
  [[nodiscard]] static hal::Result<std::unique_ptr<Ros2CameraServer>> start(
      const Ros2CameraServerConfig& config, std::unique_ptr<VideoSource> source);
  ~Ros2CameraServer() override;

  void begin() override;
  void stop() override;
  [[nodiscard]] Report report() const override;

 private:
  struct Impl;
  explicit Ros2CameraServer(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace colift::sim_hal
