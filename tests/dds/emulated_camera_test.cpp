// The emulated driver of ROS 2, seen by the camera's driver: its frames, and each of its faults.

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <string>
#include <utility>

#include "sim_hal/emulator/ros2/ros2_camera_server.hpp"
#include "tests/dds/camera_rig.hpp"

namespace colift::tests {
namespace {

using namespace std::chrono_literals;
using hal::ErrorCode;

/// A wall that is one millimetre further away in each picture; one column without depth.
class Wall final : public sim_hal::VideoSource {
 public:
  [[nodiscard]] const hal::CameraIntrinsics& camera() const override { return camera_; }
  [[nodiscard]] std::vector<float> look(std::uint64_t frame) override {
    std::vector<float> depth(64 * 48, 1.0F + 0.001F * static_cast<float>(frame % 1000));
    for (std::size_t v = 0; v < 48; ++v) depth[64 * v] = NAN;
    return depth;
  }

 private:
  hal::CameraIntrinsics camera_{64, 48, 60.0, 61.0, 32.0, 24.0};
};

struct EmulatedRos2 {
  hal::SteadyClock clock;
  std::unique_ptr<sim_hal::Ros2CameraServer> far_end;
  hal::Ros2Camera camera;

  static hal::Ros2CameraConfig config() {
    hal::Ros2CameraConfig c = camera_config();
    c.silent_s = 0.5;
    return c;
  }
  explicit EmulatedRos2(const std::string& fault) : camera(config(), clock) {
    sim_hal::Ros2CameraServerConfig served;
    served.domain = test_domain();
    if (!fault.empty()) served.faults.push_back(sim_hal::parse_ros2_camera_fault(fault).value());
    far_end = sim_hal::Ros2CameraServer::start(served, std::make_unique<Wall>()).value();
    if (auto done = camera.configure(); !done) FAIL(done.error().text());
    if (auto done = camera.activate(); !done) FAIL(done.error().text());
  }

  /// Frames are asked for until this holds; false: not within half a minute.
  template <class Condition>
  bool until(Condition holds) {
    for (const auto end = clock.now() + 30s; clock.now() < end;)
      if (holds(camera.next_frame(200ms))) return true;
    return false;
  }
  bool sees_again() {
    return until([](const auto& frame) { return frame && frame->depth_m[1] >= 1.0F; });
  }
};

}  // namespace

TEST_CASE("the emulated driver of ROS 2 shows its source", "[dds][emulated]") {
  EmulatedRos2 rig("");
  const auto frame = rig.camera.next_frame(10'000ms);
  REQUIRE(frame);
  CHECK(frame->intrinsics.fx == 60.0);
  CHECK(frame->intrinsics.cy == 24.0);
  CHECK(std::isnan(frame->depth_m[64 * 7]));
  CHECK(frame->depth_m[64 * 7 + 5] >= 1.0F);
  CHECK(rig.far_end->report().frames > 0);
}

TEST_CASE("a driver that is gone or silent is a lost link, and the camera is back afterwards",
          "[dds][emulated]") {
  EmulatedRos2 rig(GENERATE("0:unplug:2", "0:silent:2"));
  rig.far_end->begin();
  CHECK(rig.until([](const auto& frame) { return !frame && frame.error().code == ErrorCode::LinkLost; }));
  CHECK(rig.sees_again());
}

TEST_CASE("messages that lie are dropped and counted, and frames go on afterwards", "[dds][emulated]") {
  EmulatedRos2 rig(GENERATE("0:short:2", "0:resized:2", "0:jump=500:2", "0:restamp:2"));
  rig.far_end->begin();
  CHECK(rig.until([&](const auto&) { return rig.camera.health().rejected > 2; }));
  CHECK(rig.sees_again());
}

TEST_CASE("a picture that is blind or frozen comes as it is: the guard judges it", "[dds][emulated]") {
  SECTION("blind") {
    EmulatedRos2 rig("0:blind:2");
    rig.far_end->begin();
    CHECK(rig.until([](const auto& frame) {
      return frame &&
             std::all_of(frame->depth_m.begin(), frame->depth_m.end(), [](float d) { return std::isnan(d); });
    }));
    CHECK(rig.sees_again());
  }
  SECTION("frozen") {
    EmulatedRos2 rig("0:freeze:2");
    rig.far_end->begin();
    float last = 0.0F;
    CHECK(rig.until(
        [&](const auto& frame) { return frame && std::exchange(last, frame->depth_m[1]) == last; }));
    CHECK(rig.until([&](const auto& frame) { return frame && frame->depth_m[1] > last + 0.0005F; }));
  }
}

TEST_CASE("a fault that this camera has not is refused with those it has", "[dds][emulated]") {
  const auto none = sim_hal::parse_ros2_camera_fault("1:packets=3");
  REQUIRE_FALSE(none);
  CHECK_THAT(none.error().text(),
             Catch::Contains("no fault of the camera over ROS 2") && Catch::Contains("restamp"));
  CHECK_FALSE(sim_hal::parse_ros2_camera_fault("1:short=100"));
  CHECK(sim_hal::parse_ros2_camera_fault("1:late=50:2")->value == 50.0);
}

}  // namespace colift::tests
