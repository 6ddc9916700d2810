#pragma once

#include <atomic>
#include <functional>
#include <mutex>
#include <thread>

#include "hal/drivers/ros2_camera/ros2_camera.hpp"
#include "tests/dds/peer_process.hpp"
#include "tests/dds/ros_messages.hpp"

namespace colift::tests {

/// A driver of ROS 2 by the other implementation: depth images and camera models at 30 Hz. What it sends can
/// be changed while it runs.
class FastCamera {
 public:
  using Change = std::function<void(RosImage&, RosCameraInfo&)>;

  explicit FastCamera(int domain, Change change = {}, const std::string& prefix = "rt/camera/depth")
      : peer_(domain),
        image_(peer_.writer(prefix + "/image_rect_raw", "sensor_msgs::msg::dds_::Image_", {false, false, 5})),
        info_(peer_.writer(prefix + "/camera_info", "sensor_msgs::msg::dds_::CameraInfo_", {true, false, 5})),
        change_(std::move(change)),
        thread_([this] { run(); }) {}
  ~FastCamera() {
    ends_ = true;
    thread_.join();
  }

  void change(Change change) {
    const std::lock_guard lock(mutex_);
    change_ = std::move(change);
  }
  [[nodiscard]] int sent() const { return sent_; }

  /// A floor 2 m away, a column without depth, a box in the middle.
  static RosImage image(int number) {
    RosImage m;
    m.header = {system_stamp(), "camera_depth_optical_frame"};
    m.width = 64, m.height = 48, m.encoding = "16UC1", m.step = 128;
    m.data.resize(128 * 48);
    for (std::uint32_t v = 0; v < 48; ++v)
      for (std::uint32_t u = 0; u < 64; ++u) {
        const unsigned mm = u == 0                       ? 0
                            : u > 20 && u < 40 && v > 20 ? 1500
                                                         : 2000 + static_cast<unsigned>(number) % 50;
        m.data[128 * v + 2 * u] = static_cast<std::uint8_t>(mm & 0xff);
        m.data[128 * v + 2 * u + 1] = static_cast<std::uint8_t>(mm >> 8);
      }
    return m;
  }
  static RosCameraInfo info() {
    RosCameraInfo m;
    m.header = {system_stamp(), "camera_depth_optical_frame"};
    m.width = 64, m.height = 48, m.distortion_model = "plumb_bob", m.d = {0, 0, 0, 0, 0};
    m.k = {60, 0, 32, 0, 61, 24, 0, 0, 1};
    m.r = {1, 0, 0, 0, 1, 0, 0, 0, 1};
    m.p = {60, 0, 32, 0, 0, 61, 24, 0, 0, 0, 1, 0};
    return m;
  }

 private:
  void run() {
    while (!ends_) {
      RosImage m = image(sent_);
      RosCameraInfo i = info();
      Change change;
      {
        const std::lock_guard lock(mutex_);
        change = change_;
      }
      if (change) change(m, i);
      (void)info_->write(bytes_of(i));
      (void)image_->write(bytes_of(m));
      ++sent_;
      std::this_thread::sleep_for(std::chrono::milliseconds(33));
    }
  }

  FastPeer peer_;
  std::unique_ptr<FastPeer::Writer> image_, info_;
  std::mutex mutex_;
  Change change_;
  std::atomic<bool> ends_{false};
  std::atomic<int> sent_{0};
  std::thread thread_;
};

inline hal::Ros2CameraConfig camera_config() {
  hal::Ros2CameraConfig c;
  c.domain = test_domain();
  c.open_s = 30.0;
  c.silent_s = 5.0;  // a test machine may be busy
  c.max_age_s = 5.0;
  return c;
}

/// The driver with its far end.
struct Ros2CameraRig {
  hal::SteadyClock clock;
  FastCamera far_end;
  hal::Ros2Camera camera;
  explicit Ros2CameraRig(FastCamera::Change change = {}, hal::Ros2CameraConfig config = camera_config())
      : far_end(config.domain, std::move(change)), camera(std::move(config), clock) {}
};

}  // namespace colift::tests
