#include "sim_hal/mock/mock_camera.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <cstring>

using namespace colift::sim_hal;
using namespace std::chrono_literals;
using colift::hal::ErrorCode;
using colift::hal::ManualClock;
using State = colift::hal::DeviceHealth::State;

namespace {

/// A ball that comes 10 cm nearer with every frame, filmed at 25 Hz.
CameraScript approaching_ball() {
  CameraScript script;
  script.world = [](std::uint64_t frame) {
    World world;
    world.shapes.push_back(half_space({0, 0, 3}, {0, 0, -1}, Label::Wall));
    world.shapes.push_back(sphere({0, 0, 2.2 - 0.1 * static_cast<double>(frame)}, 0.2, Label::Target));
    return world;
  };
  script.intrinsics = {64, 48, 57.6, 57.6, 32, 24};
  script.ideal = true;
  script.period = 40ms;
  return script;
}

MockCamera streaming(CameraScript script, ManualClock& clock) {
  MockCamera camera(std::move(script), clock);
  REQUIRE(camera.configure());
  REQUIRE(camera.activate());
  return camera;
}

float middle(const colift::hal::DepthFrame& frame) {
  return frame.depth_m.at(24 * 64 + 32);
}

}  // namespace

TEST_CASE("waiting for a frame takes until its exposure, on the handed-in clock", "[mock_camera]") {
  ManualClock clock;
  MockCamera camera = streaming(approaching_ball(), clock);
  for (int n = 0; n < 4; ++n) {
    const auto frame = camera.next_frame(100ms);
    REQUIRE(frame);
    CHECK(frame->exposed_at == n * 40ms);
    CHECK(clock.now() == n * 40ms);
    CHECK(middle(*frame) == Approx(2.0 - 0.1 * n).margin(1e-5));
  }
  CHECK(camera.health().state == State::Streaming);
  CHECK(camera.health().accepted == 4);
}

TEST_CASE("who is late gets the newest frame, never the same twice", "[mock_camera]") {
  ManualClock clock;
  MockCamera camera = streaming(approaching_ball(), clock);
  REQUIRE(camera.next_frame(0ms));
  clock.advance(210ms);
  const auto newest = camera.next_frame(0ms);
  REQUIRE(newest);
  CHECK(newest->exposed_at == 200ms);
  const auto early = camera.next_frame(10ms);
  REQUIRE_FALSE(early);
  CHECK(early.error().code == ErrorCode::Timeout);
  CHECK(clock.now() == 220ms);
  CHECK(camera.health().state == State::Stalled);
  CHECK(camera.next_frame(30ms)->exposed_at == 240ms);
}

TEST_CASE("dropped frames end in a timeout, or in the next good one for who waits long enough",
          "[mock_camera]") {
  ManualClock clock;
  MockCamera camera = streaming(approaching_ball(), clock);
  camera.inject(MockCamera::Fault::Drop, 1, 3);
  REQUIRE(camera.next_frame(50ms));
  const auto missing = camera.next_frame(50ms);
  REQUIRE_FALSE(missing);
  CHECK(missing.error().code == ErrorCode::Timeout);
  const auto good = camera.next_frame(500ms);
  REQUIRE(good);
  CHECK(good->exposed_at == 160ms);
  CHECK(camera.health().rejected == 3);
}

TEST_CASE("a frozen camera shows the old image under a new time", "[mock_camera]") {
  ManualClock clock;
  MockCamera camera = streaming(approaching_ball(), clock);
  camera.inject(MockCamera::Fault::Freeze, 1, 2);
  const auto before = camera.next_frame(50ms), frozen = camera.next_frame(50ms);
  REQUIRE(frozen);
  CHECK(frozen->exposed_at == 40ms);
  CHECK(middle(*frozen) == middle(*before));
  REQUIRE(camera.next_frame(50ms));
  CHECK(middle(*camera.next_frame(50ms)) == Approx(1.7).margin(1e-5));
}

TEST_CASE("frames without data and of the wrong size come on request", "[mock_camera]") {
  ManualClock clock;
  MockCamera camera = streaming(approaching_ball(), clock);
  camera.inject(MockCamera::Fault::AllNan, 0);
  camera.inject(MockCamera::Fault::WrongSize, 1);
  const auto blind = camera.next_frame(50ms);
  for (const float z : blind->depth_m) REQUIRE(std::isnan(z));
  CHECK(camera.next_frame(50ms)->depth_m.size() == 64 * 48 / 2);
  CHECK(camera.next_frame(50ms)->depth_m.size() == 64 * 48);
}

TEST_CASE("an unplugged mock camera is lost until it is plugged in and configured again", "[mock_camera]") {
  ManualClock clock;
  MockCamera camera = streaming(approaching_ball(), clock);
  camera.inject(MockCamera::Fault::Unplug, 1, 3);
  REQUIRE(camera.next_frame(50ms));
  CHECK(camera.next_frame(50ms).error().code == ErrorCode::LinkLost);
  CHECK(camera.health().state == State::Lost);
  CHECK(camera.configure().error().code == ErrorCode::LinkLost);
  CHECK(camera.next_frame(50ms).error().code == ErrorCode::LinkLost);
  clock.advance(130ms);
  REQUIRE(camera.configure());
  CHECK(camera.next_frame(50ms).error().code == ErrorCode::NotReady);
  REQUIRE(camera.activate());
  CHECK(camera.next_frame(50ms)->exposed_at == 160ms);
}

TEST_CASE("a camera that was not activated, or has nothing to film, says so", "[mock_camera]") {
  ManualClock clock;
  MockCamera idle(approaching_ball(), clock);
  CHECK(idle.activate().error().code == ErrorCode::NotReady);
  CHECK(idle.next_frame(10ms).error().code == ErrorCode::NotReady);
  MockCamera empty(CameraScript{}, clock);
  CHECK(empty.configure().error().code == ErrorCode::BadConfig);
  CHECK(empty.health().state == State::Failed);
}

TEST_CASE("two cameras with the same script and seed film the same bits", "[mock_camera]") {
  CameraScript script = approaching_ball();
  script.ideal = false;
  script.seed = 4;
  ManualClock clock_a, clock_b;
  MockCamera a = streaming(script, clock_a), b = streaming(script, clock_b);
  const auto first = a.next_frame(0ms), same = b.next_frame(0ms), second = a.next_frame(50ms);
  const std::size_t bytes = first->depth_m.size() * sizeof(float);
  CHECK(std::memcmp(first->depth_m.data(), same->depth_m.data(), bytes) == 0);
  // noise differs from frame to frame, also where the world stands still
  CHECK(std::memcmp(first->depth_m.data(), second->depth_m.data(), 20 * sizeof(float)) != 0);
}
