#include <catch2/catch.hpp>
#include <chrono>
#include <cmath>
#include <memory>

#include "hal/drivers/recorded/recorded_camera.hpp"
#include "sim_hal/mock/mock_camera.hpp"
#include "sim_hal/mujoco/devices/sim_devices.hpp"
#ifdef COLIFT_KINECT
#include "tests/support/camera_rig.hpp"
#endif

namespace colift {
namespace {

using namespace std::chrono_literals;

// A back end that is ready to be configured, and what it needs to live.
struct RecordedRig {
  hal::RecordedCamera camera{
      hal::RecordedCameraConfig{std::string(COLIFT_TEST_DATA) + "/real/02_laptop_and_box", 0.25, true}};
};

struct MockRig {
  hal::ManualClock clock;
  sim_hal::MockCamera camera{script(), clock};

  static sim_hal::CameraScript script() {
    sim_hal::CameraScript s;
    s.world = [](std::uint64_t) {
      sim_hal::World world;
      world.shapes.push_back(
          sim_hal::half_space(hal::Vec3::Zero(), hal::Vec3::UnitZ(), sim_hal::Label::Ground));
      return world;
    };
    s.X_WC = sim_hal::look_at({-1.0, 0, 1.0}, {0, 0, 0});
    return s;
  }
};

struct SimRig {
  std::unique_ptr<sim_hal::SimWorld> world =
      sim_hal::SimWorld::make(sim_hal::built_in_scenario(), hal::built_in_robot(), 1, sim_hal::SimConfig{})
          .value();
  std::unique_ptr<hal::DepthCamera> owned = sim_hal::make_sim_camera(*world);
  hal::DepthCamera& camera = *owned;
};

// in real time, through the capture process
#ifdef COLIFT_KINECT
using tests::CameraRig;
#define COLIFT_CAMERAS RecordedRig, MockRig, SimRig, CameraRig
#else
#define COLIFT_CAMERAS RecordedRig, MockRig, SimRig
#endif

}  // namespace

TEMPLATE_TEST_CASE("a depth camera gives nothing before it is configured and activated", "[camera][contract]",
                   COLIFT_CAMERAS) {
  TestType rig;
  const auto early = rig.camera.next_frame(10ms);
  REQUIRE_FALSE(early);
  CHECK(early.error().code == hal::ErrorCode::NotReady);
  CHECK_FALSE(early.error().detail.empty());
  CHECK_FALSE(rig.camera.activate());
  REQUIRE(rig.camera.configure());
  CHECK_FALSE(rig.camera.next_frame(10ms));
  REQUIRE(rig.camera.activate());
  CHECK(rig.camera.next_frame(1s));
}

TEMPLATE_TEST_CASE("frames are whole, in metres, and NaN where nothing was seen", "[camera][contract]",
                   COLIFT_CAMERAS) {
  TestType rig;
  REQUIRE(rig.camera.configure());
  REQUIRE(rig.camera.activate());
  for (int i = 0; i < 3; ++i) {
    const auto frame = rig.camera.next_frame(1s);
    REQUIRE(frame);
    const auto& k = frame->intrinsics;
    REQUIRE(frame->depth_m.size() == static_cast<std::size_t>(k.width) * static_cast<std::size_t>(k.height));
    CHECK(k.fx > 0);
    CHECK(k.fy > 0);
    std::size_t seen = 0, wrong = 0;
    for (const float d : frame->depth_m) {
      if (std::isnan(d)) continue;
      ++seen;
      wrong += !(d > 0.1f && d < 20.0f);
    }
    CHECK(seen > frame->depth_m.size() / 4);
    CHECK(wrong == 0);
    CHECK((frame->rgb.empty() || frame->rgb.size() == 3 * frame->depth_m.size()));
    if (frame->up_C) CHECK(frame->up_C->norm() == Approx(1.0).epsilon(1e-9));
  }
}

TEMPLATE_TEST_CASE("each frame is newer than the one before", "[camera][contract]", COLIFT_CAMERAS) {
  TestType rig;
  REQUIRE(rig.camera.configure());
  REQUIRE(rig.camera.activate());
  auto last = rig.camera.next_frame(1s);
  REQUIRE(last);
  // more than a round of the recording, so that its loop is seen too
  for (int i = 0; i < 7; ++i) {
    const auto frame = rig.camera.next_frame(1s);
    REQUIRE(frame);
    CHECK(frame->exposed_at > last->exposed_at);
    last->exposed_at = frame->exposed_at;
  }
}

TEMPLATE_TEST_CASE("a camera at rest gives nothing, and goes on when it is activated again",
                   "[camera][contract]", COLIFT_CAMERAS) {
  TestType rig;
  REQUIRE(rig.camera.configure());
  REQUIRE(rig.camera.activate());
  REQUIRE(rig.camera.next_frame(1s));
  rig.camera.deactivate();
  rig.camera.deactivate();
  CHECK_FALSE(rig.camera.next_frame(10ms));
  REQUIRE(rig.camera.activate());
  CHECK(rig.camera.next_frame(1s));
}

TEMPLATE_TEST_CASE("health counts what was handed out", "[camera][contract]", COLIFT_CAMERAS) {
  TestType rig;
  CHECK(rig.camera.health().accepted == 0);
  REQUIRE(rig.camera.configure());
  REQUIRE(rig.camera.activate());
  for (int i = 0; i < 4; ++i) REQUIRE(rig.camera.next_frame(1s));
  CHECK(rig.camera.health().accepted == 4);
  CHECK(rig.camera.health().rejected == 0);
  CHECK(rig.camera.health().state == hal::DeviceHealth::State::Streaming);
}

}  // namespace colift
