// The last gate behind a camera: safety-and-faults, rows 5 to 8 and 11.

#include <catch2/catch.hpp>
#include <cmath>
#include <deque>
#include <functional>
#include <limits>

#include "hal/guards/guarded_camera.hpp"

using namespace colift::hal;
using namespace std::chrono_literals;

namespace {

constexpr auto kPeriod = 33ms;
constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

/// A camera that hands out what a test puts in.
class PlayedCamera final : public DepthCamera {
 public:
  std::deque<Result<DepthFrame>> frames;
  Result<> configure() override { return {}; }
  Result<> activate() override { return {}; }
  void deactivate() noexcept override {}
  DeviceHealth health() const override { return {}; }
  Result<DepthFrame> next_frame(std::chrono::milliseconds) override {
    if (frames.empty()) return failure(ErrorCode::Timeout, "played", "none");
    auto f = std::move(frames.front());
    frames.pop_front();
    return f;
  }
};

struct Rig {
  ManualClock clock;
  PlayedCamera* inner = new PlayedCamera;  // owned by the guard
  GuardedCamera camera;
  int number = 0;

  explicit Rig(const CameraGuardConfig& config = {}, std::optional<Vec3> up = std::nullopt)
      : camera(std::unique_ptr<DepthCamera>(inner), config, clock, up) {
    clock.advance(10s);
    REQUIRE(camera.configure());
    REQUIRE(camera.activate());
  }

  DepthFrame picture() {
    DepthFrame f;
    f.intrinsics = {64, 48, 57.6, 57.6, 32, 24};
    f.exposed_at = clock.now() - 20ms;
    f.depth_m.resize(64UL * 48);
    ++number;
    for (std::size_t i = 0; i < f.depth_m.size(); ++i)
      f.depth_m[i] = 1.0f + 0.001f * static_cast<float>((i * 7 + static_cast<std::size_t>(number) * 13) % 17);
    return f;
  }

  /// One period later: a frame, spoiled.
  Result<DepthFrame> show(const std::function<void(DepthFrame&)>& spoil = {}) {
    clock.advance(kPeriod);
    DepthFrame f = picture();
    if (spoil) spoil(f);
    inner->frames.push_back(std::move(f));
    return camera.next_frame(0ms);
  }
};

bool is(const Result<DepthFrame>& r, ErrorCode code) {
  return !r && r.error().code == code;
}

}  // namespace

TEST_CASE("good frames pass as they are", "[guards]") {
  Rig rig;
  for (int i = 0; i < 100; ++i) REQUIRE(rig.show());
  CHECK(rig.camera.health().accepted == 100);
  CHECK(rig.camera.health().rejected == 0);
}

TEST_CASE("a frame that shows nothing, is not whole or has no metres is dropped; five in a row are a loss",
          "[guards][faults]") {
  using Spoil = std::function<void(DepthFrame&)>;
  const auto [what, spoil] = GENERATE(table<std::string, Spoil>({
      {"all NaN", [](DepthFrame& f) { std::fill(f.depth_m.begin(), f.depth_m.end(), kNan); }},
      {"all zeros", [](DepthFrame& f) { std::fill(f.depth_m.begin(), f.depth_m.end(), 0.0f); }},
      {"all maximum", [](DepthFrame& f) { std::fill(f.depth_m.begin(), f.depth_m.end(), 65.535f); }},
      {"infinite",
       [](DepthFrame& f) {
         std::fill(f.depth_m.begin(), f.depth_m.end(), std::numeric_limits<float>::infinity());
       }},
      {"negative", [](DepthFrame& f) { std::fill(f.depth_m.begin(), f.depth_m.end(), -1.0f); }},
      {"millimetres",
       [](DepthFrame& f) {
         for (float& z : f.depth_m) z *= 1000.0f;
       }},
      {"half of the rows", [](DepthFrame& f) { f.depth_m.resize(f.depth_m.size() / 2); }},
      {"too many pixels", [](DepthFrame& f) { f.depth_m.resize(2 * f.depth_m.size(), 1.0f); }},
      {"no pixels", [](DepthFrame& f) { f.depth_m.clear(); }},
      {"no lens", [](DepthFrame& f) { f.intrinsics.fx = 0.0; }},
      {"negative width", [](DepthFrame& f) { f.intrinsics.width = -64; }},
      {"half of the colour", [](DepthFrame& f) { f.rgb.resize(100); }},
      {"old", [](DepthFrame& f) { f.exposed_at -= 1s; }},
  }));
  INFO(what);
  Rig rig;
  REQUIRE(rig.show());
  CHECK(is(rig.show(spoil), ErrorCode::Timeout));
  REQUIRE(rig.show());  // nothing else has changed
  for (int i = 0; i < 4; ++i) CHECK(is(rig.show(spoil), ErrorCode::Timeout));
  CHECK(is(rig.show(spoil), ErrorCode::LinkLost));
  CHECK(rig.camera.health().state == DeviceHealth::State::Lost);
  CHECK(rig.camera.health().rejected == 6);
  // back after thirty good ones, not before
  for (int i = 0; i < 29; ++i) CHECK(is(rig.show(), ErrorCode::LinkLost));
  CHECK(rig.show());
}

TEST_CASE("the same picture under new times is a dead camera within 0.3 s", "[guards][faults]") {
  Rig rig;
  const auto last = rig.show();
  REQUIRE(last);
  const auto stuck = [&](DepthFrame& f) { f.depth_m = last->depth_m; };
  int passed = 0;
  while (rig.show(stuck)) ++passed;
  CHECK(passed * 33 <= 233);
  CHECK(is(rig.show(stuck), ErrorCode::LinkLost));
  int good = 0;
  while (!rig.show()) ++good;
  CHECK(good == 29);
}

TEST_CASE("an ideal camera in front of a scene at rest may show the same picture, where that is said",
          "[guards]") {
  CameraGuardConfig config;
  config.frozen_s = 0.0;
  Rig rig(config);
  const auto last = rig.show();
  REQUIRE(last);
  for (int i = 0; i < 60; ++i) CHECK(rig.show([&](DepthFrame& f) { f.depth_m = last->depth_m; }));
}

TEST_CASE("a camera that says nothing is lost after 0.2 s", "[guards][faults]") {
  Rig rig;
  REQUIRE(rig.show());
  rig.clock.advance(150ms);
  CHECK(is(rig.camera.next_frame(0ms), ErrorCode::Timeout));
  rig.clock.advance(60ms);
  CHECK(is(rig.camera.next_frame(0ms), ErrorCode::LinkLost));
}

TEST_CASE("a lost camera is back after its good frames though it is asked more often than it has any",
          "[guards]") {
  Rig rig;
  REQUIRE(rig.show());
  rig.clock.advance(400ms);
  REQUIRE(is(rig.camera.next_frame(0ms), ErrorCode::LinkLost));
  int good = 0;
  while (!rig.show() && good < 100) {
    ++good;
    for (int i = 0; i < 3; ++i) CHECK(is(rig.camera.next_frame(0ms), ErrorCode::LinkLost));
  }
  CHECK(good == 29);
}

TEST_CASE("a caller who was away for a while finds a camera, not a loss", "[guards]") {
  Rig rig;
  REQUIRE(rig.show());
  rig.clock.advance(3s);
  CHECK(rig.show());
}

TEST_CASE("a loss that the camera itself tells of passes with its words", "[guards][faults]") {
  Rig rig;
  REQUIRE(rig.show());
  rig.inner->frames.push_back(failure(ErrorCode::LinkLost, "x", "signal 9"));
  const auto lost = rig.camera.next_frame(0ms);
  REQUIRE(is(lost, ErrorCode::LinkLost));
  CHECK_THAT(lost.error().detail, Catch::Contains("signal 9"));
  CHECK(is(rig.show(), ErrorCode::LinkLost));
}

TEST_CASE("frames that come late in the mean are a loss", "[guards][faults]") {
  Rig rig;
  for (int i = 0; i < 10; ++i) REQUIRE(rig.show());
  const auto late = [](DepthFrame& f) { f.exposed_at -= 500ms; };
  int more = 0;
  rig.clock.advance(500ms);
  while (rig.show(late) && more < 100) ++more;
  CHECK(more > 2);  // one alone is none
  CHECK(more < 20);
  CHECK(rig.camera.health().state == DeviceHealth::State::Lost);
}

TEST_CASE("a camera that was moved gives no frames until it hangs again as before", "[guards][faults]") {
  const Vec3 up(0.0, -std::cos(0.5), -std::sin(0.5));
  Rig rig({}, up);
  const auto hangs = [&](double deg) {
    return [=](DepthFrame& f) { f.up_C = Eigen::AngleAxisd(deg / 57.29578, Vec3::UnitX()) * up; };
  };
  REQUIRE(rig.show(hangs(0.0)));
  REQUIRE(rig.show(hangs(0.3)));
  const auto moved = rig.show(hangs(5.0));
  REQUIRE(is(moved, ErrorCode::DeviceFault));
  CHECK_THAT(moved.error().detail, Catch::Contains("5.0 deg") && Catch::Contains("calibrate"));
  rig.clock.advance(1s);
  CHECK(is(rig.camera.next_frame(0ms), ErrorCode::DeviceFault));
  for (int i = 0; i < 29; ++i) CHECK_FALSE(rig.show(hangs(0.1)));
  CHECK(rig.show(hangs(0.1)));
}

TEST_CASE("a camera that hangs otherwise than when it was calibrated gives no frame at all",
          "[guards][faults]") {
  const Vec3 up = -Vec3::UnitY();
  Rig rig({}, up);
  const auto f = rig.show([&](DepthFrame& d) { d.up_C = Eigen::AngleAxisd(0.087, Vec3::UnitX()) * up; });
  REQUIRE(is(f, ErrorCode::DeviceFault));
  CHECK_THAT(f.error().detail, Catch::Contains("calibration"));
}
