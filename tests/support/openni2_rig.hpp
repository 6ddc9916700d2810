#pragma once

#include <catch2/catch.hpp>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "hal/drivers/openni2_camera/openni2_camera.hpp"
#include "sim_hal/emulator/camera/camera_server.hpp"

namespace colift::tests {

/// The driver of an OpenNI2 camera whose capture process finds an emulated device through OpenNI2's own
/// library: a box on the floor that moves a little.
struct Openni2Rig {
  hal::SteadyClock clock;
  hal::Pose X_WC = sim_hal::look_at({-1.2, 0.1, 1.2}, {0, 0, 0.2});
  sim_hal::CameraServer server;
  hal::Openni2Camera camera;

  explicit Openni2Rig(std::optional<sim_hal::KinectNoise> noise = sim_hal::KinectNoise{},
                      const std::vector<std::string>& faults = {},
                      const hal::Openni2CameraConfig& config = camera_config(),
                      std::optional<hal::openni2::PinholeModel> model = std::nullopt,
                      std::function<sim_hal::World(double)> in_front = world)
      : server(server_config(faults),
               std::make_unique<sim_hal::ScriptedCameraSource>(std::move(in_front), X_WC, noise, 1, clock)),
        camera(with_address(config, server.address()), model, clock) {
    if (auto started = server.start(); !started) FAIL(started.error().text());
  }

  static sim_hal::World world(double t_s) {
    sim_hal::World w;
    w.shapes.push_back(sim_hal::half_space(hal::Vec3::Zero(), hal::Vec3::UnitZ(), sim_hal::Label::Ground));
    w.shapes.push_back(sim_hal::box({0.02 * t_s, 0.2, 0.2}, {0.4, 0.4, 0.4}, 0.3, sim_hal::Label::Target));
    return w;
  }
  static sim_hal::CameraServerConfig server_config(const std::vector<std::string>& faults) {
    sim_hal::CameraServerConfig c;
    for (const std::string& f : faults) c.faults.push_back(sim_hal::parse_camera_fault(f).value());
    return c;
  }
  static hal::Openni2CameraConfig camera_config() {
    hal::Openni2CameraConfig c;
    c.latency_ms = 5.0;
    c.open_s = 20.0;  // a test machine may be busy
    return c;
  }
  static hal::Openni2CameraConfig with_address(hal::Openni2CameraConfig c, const std::string& address) {
    if (c.source == "any") c.source = "emulated:" + address;
    return c;
  }

  void fault(const std::string& text) { server.inject(sim_hal::parse_camera_fault(text).value()); }

  void open() {
    if (auto done = camera.configure(); !done) FAIL(done.error().text());
    if (auto done = camera.activate(); !done) FAIL(done.error().text());
  }

  /// Waits for it, for half a minute at most.
  template <class Condition>
  bool until(const Condition& condition) {
    const hal::Timestamp end = clock.now() + std::chrono::seconds(30);
    while (clock.now() < end) {
      if (condition()) return true;
      std::this_thread::sleep_for(std::chrono::milliseconds(2));
    }
    return false;
  }

  /// Asks for frames until one comes; fails after half a minute.
  hal::DepthFrame frame() {
    std::optional<hal::DepthFrame> got;
    if (!until([&] {
          auto next = camera.next_frame(std::chrono::milliseconds(20));
          if (next) got = std::move(*next);
          return got.has_value();
        }))
      FAIL("no frame: " << camera.health().last_error);
    return std::move(*got);
  }

  /// Asks for frames until there is something else than a frame or no frame yet.
  hal::Error until_error() {
    hal::Error error{hal::ErrorCode::Timeout, "", "nothing went wrong"};
    (void)until([&] {
      const auto next = camera.next_frame(std::chrono::milliseconds(0));
      if (!next) error = next.error();
      return !next && error.code != hal::ErrorCode::Timeout;
    });
    return error;
  }
};

}  // namespace colift::tests
