#pragma once

#include <catch2/catch.hpp>
#include <memory>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "hal/drivers/v4l2_camera/v4l2_camera.hpp"
#include "sim_hal/emulator/video/emulated_video.hpp"

namespace colift::tests {

/// Of a small depth camera, so that a picture costs little.
inline const hal::CameraIntrinsics kSmallCamera{160, 120, 150.0, 151.0, 80.0, 60.0};

/// A box on the floor that moves a little.
inline sim_hal::World box_world(double t_s) {
  sim_hal::World w;
  w.shapes.push_back(sim_hal::half_space(hal::Vec3::Zero(), hal::Vec3::UnitZ(), sim_hal::Label::Ground));
  w.shapes.push_back(sim_hal::box({0.02 * t_s, 0, 0.2}, {0.4, 0.4, 0.4}, 0.3, sim_hal::Label::Target));
  return w;
}

inline std::unique_ptr<sim_hal::VideoSource> box_source(const hal::Clock& clock,
                                                        std::optional<sim_hal::KinectNoise> noise) {
  return std::make_unique<sim_hal::ScriptedVideoSource>(
      box_world, kSmallCamera, sim_hal::look_at({-1.2, 0, 1.2}, {0, 0, 0.2}), noise, 1, clock);
}

inline hal::V4l2CameraConfig video_config() {
  hal::V4l2CameraConfig c;
  c.open_s = 20.0;  // a test machine may be busy
  c.silent_s = 5.0;
  c.max_age_s = 5.0;
  return c;
}

inline hal::v4l2::DepthModel video_model() {
  return {kSmallCamera, {}, 0.001};
}

inline sim_hal::EmulatedVideoConfig video_device(const std::vector<std::string>& faults = {}) {
  sim_hal::EmulatedVideoConfig c;
  for (const std::string& f : faults) c.faults.push_back(sim_hal::parse_video_fault(f).value());
  return c;
}

/// The driver with its far end, in real time.
struct VideoRig {
  hal::SteadyClock clock;
  std::shared_ptr<sim_hal::EmulatedVideo> device;
  hal::V4l2Camera camera;

  explicit VideoRig(const std::vector<std::string>& faults = {},
                    hal::V4l2CameraConfig config = video_config())
      : device(std::make_shared<sim_hal::EmulatedVideo>(video_device(faults),
                                                        box_source(clock, sim_hal::KinectNoise{}), clock)),
        camera(std::move(config), video_model(), device, clock) {}

  void fault(const std::string& text) { device->inject(sim_hal::parse_video_fault(text).value()); }

  /// Asks for frames until there is a frame, or none, as wanted; for half a minute at most.
  hal::Result<hal::DepthFrame> until(bool frame) {
    const hal::Timestamp end = clock.now() + std::chrono::seconds(30);
    for (;;) {
      auto got = camera.next_frame(std::chrono::milliseconds(20));
      const bool waits = !got && got.error().code == hal::ErrorCode::Timeout;
      if ((got.has_value() == frame && !waits) || clock.now() > end) return got;
      if (!got && !waits) std::this_thread::sleep_for(std::chrono::milliseconds(2));
    }
  }
};

}  // namespace colift::tests
