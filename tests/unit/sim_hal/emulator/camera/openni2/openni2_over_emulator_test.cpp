// The camera's driver, its capture process, OpenNI2's own library and an emulated device behind it. In real
// time, with timeouts of seconds for what takes milliseconds: a slow machine makes these tests slow, not
// wrong.

#include <signal.h>

#include <catch2/catch.hpp>
#include <cmath>

#include "tests/support/openni2_rig.hpp"

using namespace colift;
using namespace std::chrono_literals;
using tests::Openni2Rig;

namespace {

struct Agreement {
  std::size_t compared = 0, off = 0;
};

/// Pixels of an ideal camera's frame that are not the depth that is there, within one code of the sensor and
/// one unit of the image.
Agreement compare(const hal::DepthFrame& frame, const hal::Pose& X_WC, int step = 1) {
  const auto truth = sim_hal::cast_rays(Openni2Rig::world(0.0), hal::CameraIntrinsics{}, X_WC);
  const auto width = static_cast<std::size_t>(frame.intrinsics.width);
  const auto stride = static_cast<std::size_t>(step);
  Agreement a;
  for (std::size_t i = 0; i < frame.depth_m.size(); ++i) {
    const float z = truth.depth_m[i / width * stride * 640 + i % width * stride];
    if (!(z > 0.5f && z < 6.0f)) continue;
    ++a.compared;
    a.off += !(std::abs(frame.depth_m[i] - z) <= z * z / 345.5f + 0.002f);
  }
  return a;
}

}  // namespace

TEST_CASE("frames of an emulated device come through OpenNI2", "[openni2][emulated]") {
  Openni2Rig rig;
  rig.open();
  hal::Timestamp last = hal::Timestamp::min();
  for (int i = 0; i < 10; ++i) {
    const auto frame = rig.frame();
    CHECK(frame.exposed_at > last);
    CHECK(frame.exposed_at <= rig.clock.now());
    last = frame.exposed_at;
    REQUIRE(frame.depth_m.size() == 640UL * 480);
    CHECK(frame.intrinsics.fx == Approx(575.8).epsilon(1e-4));
    CHECK(frame.intrinsics.fy == Approx(575.8).epsilon(1e-4));
    CHECK(frame.intrinsics.cx == 320.0);
    CHECK(frame.intrinsics.cy == 240.0);
  }
  const hal::Openni2Report report = rig.camera.report();
  CHECK(report.serial == "EMULATED0001");
  CHECK(report.name == "CoLift emulated depth camera");
  CHECK(report.starts == 1);
  CHECK(rig.camera.health().accepted == 10);
  CHECK(rig.camera.health().state == hal::DeviceHealth::State::Streaming);
}

TEST_CASE("neither mirrored nor registered, though the device begins so: depth is where it is",
          "[openni2][emulated]") {
  const std::string unit = GENERATE("1mm", "100um");
  const int step = GENERATE(1, 2);
  auto config = Openni2Rig::camera_config();
  config.unit = unit;
  config.width = 640 / step;
  config.height = 480 / step;
  const auto at_rest = [](double) { return Openni2Rig::world(0.0); };
  Openni2Rig rig(std::nullopt, {}, config, std::nullopt, at_rest);
  rig.open();
  const auto frame = rig.frame();
  CHECK(frame.intrinsics.fx == Approx(575.8 / step).epsilon(1e-4));
  CHECK(frame.intrinsics.cx == 320.0 / step);
  REQUIRE(frame.depth_m.size() == 640UL * 480 / static_cast<std::size_t>(step * step));
  const Agreement a = compare(frame, rig.X_WC, step);
  CHECK(a.compared > 200'000 / static_cast<std::size_t>(step * step));
  CHECK(a.off == 0);
}

TEST_CASE("a mode that the device has not is refused with those that it has", "[openni2][emulated]") {
  auto config = Openni2Rig::camera_config();
  config.width = 1280;
  Openni2Rig rig(std::nullopt, {}, config);
  const auto open = rig.camera.configure();
  REQUIRE_FALSE(open);
  CHECK(open.error().code == hal::ErrorCode::DeviceFault);
  CHECK_THAT(open.error().detail, Catch::Contains("640 x 480 at 30 Hz in 1 mm"));
  CHECK_THAT(open.error().detail, Catch::Contains("320 x 240 at 30 Hz in 0.1 mm"));
}

TEST_CASE("intrinsics of a file replace the device's, and frames of another size are refused",
          "[openni2][emulated]") {
  hal::openni2::PinholeModel model{{640, 480, 570.0, 571.0, 315.0, 242.0}, {}};
  Openni2Rig rig(std::nullopt, {}, Openni2Rig::camera_config(), model);
  rig.open();
  CHECK(rig.frame().intrinsics.fy == 571.0);

  model.intrinsics.width = 320;
  Openni2Rig other(std::nullopt, {}, Openni2Rig::camera_config(), model);
  other.open();
  CHECK(other.until_error().code == hal::ErrorCode::LinkLost);
  CHECK_THAT(other.camera.health().last_error, Catch::Contains("320 x 480"));
}

TEST_CASE("a device that is not there is said, and found when it comes", "[openni2][emulated][faults]") {
  Openni2Rig rig(sim_hal::KinectNoise{}, {"0:unplug:1.0"});
  const auto open = rig.camera.configure();
  REQUIRE_FALSE(open);
  CHECK(open.error().code == hal::ErrorCode::LinkLost);
  CHECK_THAT(open.error().detail, Catch::Contains("no device"));
  CHECK(rig.until([&] { return rig.camera.configure().has_value(); }));
}

TEST_CASE(
    "a capture process of OpenNI2 that is killed or stopped costs the camera, and the camera comes back",
    "[openni2][emulated][faults]") {
  const int signal = GENERATE(SIGKILL, SIGSTOP, SIGSEGV);
  Openni2Rig rig;
  rig.open();
  (void)rig.frame();
  const pid_t first = rig.camera.report().pid;
  REQUIRE(first > 0);
  REQUIRE(::kill(first, signal) == 0);
  const auto lost = rig.until_error();
  INFO(lost.text());
  CHECK(lost.code == hal::ErrorCode::LinkLost);
  if (signal == SIGKILL) CHECK_THAT(lost.detail, Catch::Contains("signal 9"));
  if (signal == SIGSTOP) CHECK_THAT(lost.detail, Catch::Contains("no frame for"));
  CHECK(rig.camera.health().state == hal::DeviceHealth::State::Lost);
  (void)rig.frame();
  const hal::Openni2Report report = rig.camera.report();
  CHECK(report.pid != first);
  CHECK(report.starts >= 2);
  CHECK(report.kills == (signal == SIGSTOP ? 1U : 0U));
  CHECK(::kill(first, 0) != 0);  // nothing of it is left
}

TEST_CASE("a driver of OpenNI2 that crashes or hangs costs its process, and the camera comes back",
          "[openni2][emulated][faults]") {
  const std::string fault = GENERATE("0:crash", "0:hang:600");
  Openni2Rig rig;
  rig.open();
  (void)rig.frame();
  rig.fault(fault);
  const auto lost = rig.until_error();
  CHECK(lost.code == hal::ErrorCode::LinkLost);
  if (fault == "0:crash") CHECK_THAT(lost.detail, Catch::Contains("signal 11"));
  (void)rig.frame();
  CHECK(rig.camera.report().starts >= 2);
}

TEST_CASE("a device of OpenNI2 is unplugged and plugged in again", "[openni2][emulated][faults]") {
  Openni2Rig rig;
  rig.open();
  const auto before = rig.frame();
  rig.fault("0:unplug:0.5");
  const auto lost = rig.until_error();
  CHECK(lost.code == hal::ErrorCode::LinkLost);
  CHECK_THAT(lost.detail, Catch::Contains("gone"));
  CHECK(rig.frame().exposed_at > before.exposed_at);
}

TEST_CASE("a device that is silent is lost at once and started anew when it stays so",
          "[openni2][emulated][faults]") {
  Openni2Rig rig;
  rig.open();
  (void)rig.frame();
  rig.fault("0:silent:4");
  const auto lost = rig.until_error();
  CHECK(lost.code == hal::ErrorCode::LinkLost);
  CHECK_THAT(lost.detail, Catch::Contains("no frame for"));
  REQUIRE(rig.until([&] {
    (void)rig.camera.next_frame(0ms);
    return rig.camera.report().starts >= 2;
  }));
  (void)rig.frame();
}

TEST_CASE("frames that come twice, in the wrong order or under one time are dropped and counted",
          "[openni2][emulated][faults]") {
  Openni2Rig rig;
  rig.open();
  (void)rig.frame();
  const std::string fault = GENERATE("0:double:20", "0:swap:20", "0:restamp:20");
  rig.fault(fault);
  hal::Timestamp last = rig.frame().exposed_at;
  const auto dropped = [&] {
    const auto c = rig.camera.report().dropped;
    return c.duplicate + c.old;
  };
  REQUIRE(rig.until([&] {
    if (const auto frame = rig.camera.next_frame(0ms)) {
      CHECK(frame->exposed_at > last);
      last = frame->exposed_at;
    }
    return dropped() > 0;
  }));
  CHECK(rig.camera.health().rejected >= dropped());
}

TEST_CASE("a frame that is cut short is not handed out", "[openni2][emulated][faults]") {
  Openni2Rig rig;
  rig.open();
  (void)rig.frame();
  rig.fault("0:short:0.6");
  const auto lost = rig.until_error();
  CHECK(lost.code == hal::ErrorCode::LinkLost);
  CHECK_THAT(rig.camera.report().last_words, Catch::Contains("640 x 240 pixels, expected 640 x 480"));
  CHECK(rig.frame().depth_m.size() == 640UL * 480);
  CHECK(rig.camera.report().starts == 1);
}

TEST_CASE("a device's clock that is set does not move the robot's time, forwards or backwards",
          "[openni2][emulated][faults]") {
  const std::string fault = GENERATE("0:clock=20", "0:clock=-20");
  Openni2Rig rig;
  rig.open();
  // far enough from zero to be set back
  rig.fault("0:clock=25");
  REQUIRE(rig.until([&] {
    (void)rig.camera.next_frame(0ms);
    return rig.camera.report().dropped.clock_set == 1;
  }));
  (void)rig.frame();
  rig.fault(fault);
  hal::Timestamp last = hal::Timestamp::min();
  REQUIRE(rig.until([&] {
    if (const auto frame = rig.camera.next_frame(0ms)) {
      CHECK(frame->exposed_at > last);
      CHECK(hal::seconds(rig.clock.now() - frame->exposed_at) < 10.0);
      CHECK(frame->exposed_at <= rig.clock.now());
      last = frame->exposed_at;
    }
    return rig.camera.report().dropped.clock_set == 2;
  }));
  CHECK(rig.camera.report().dropped.misdated > 0);
  (void)rig.frame();
  CHECK(rig.camera.report().starts == 1);
}

TEST_CASE("what cannot be opened is a matter of the configuration, in one sentence", "[openni2]") {
  auto config = Openni2Rig::camera_config();
  const auto [source, library, program, words] =
      GENERATE(table<std::string, std::string, std::string, std::string>({
          {"usb", "", "", "expected any, uri:URI, file:NAME.oni or emulated:ADDRESS"},
          {"uri:", "", "", "is no source"},
          {"file:/no/such.oni", "", "", "there is no recording /no/such.oni"},
          {"uri:x", "/tmp", "", "/tmp has no libOpenNI2.so.0"},
          {"uri:x", "", "/no/such", "program /no/such is not there"},
      }));
  config.source = source;
  config.library = library;
  config.program = program;
  Openni2Rig rig(std::nullopt, {}, config);
  const auto open = rig.camera.configure();
  REQUIRE_FALSE(open);
  CHECK(open.error().code == hal::ErrorCode::BadConfig);
  CHECK_THAT(open.error().detail, Catch::Contains(words));
}
