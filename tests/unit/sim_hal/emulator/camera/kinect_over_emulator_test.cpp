// The camera's driver, its capture process and an emulated Kinect behind libfreenect's functions. In real
// time, with timeouts of seconds for what takes milliseconds: a slow machine makes these tests slow, not
// wrong.

#include <signal.h>

#include <catch2/catch.hpp>
#include <cmath>

#include "tests/support/camera_rig.hpp"

using namespace colift;
using namespace std::chrono_literals;
using tests::CameraRig;

TEST_CASE("frames of an emulated Kinect come through libfreenect's functions", "[camera][emulated]") {
  CameraRig rig;
  REQUIRE(rig.camera.configure());
  REQUIRE(rig.camera.activate());
  hal::Timestamp last = hal::Timestamp::min();
  for (int i = 0; i < 10; ++i) {
    const auto frame = rig.camera.next_frame(2s);
    INFO((frame ? "" : frame.error().text()));
    REQUIRE(frame);
    CHECK(frame->exposed_at > last);
    last = frame->exposed_at;
    REQUIRE(frame->depth_m.size() == 640UL * 480);
    // the floor under the camera, and the box on it
    CHECK(frame->depth_m[470UL * 640 + 320] > 0.5f);
    REQUIRE(frame->up_C);
    CHECK((*frame->up_C - sim_hal::up_in(rig.X_WC)).norm() < 0.01);
  }
  const hal::KinectReport report = rig.camera.report();
  CHECK(report.serial == "EMULATED0001");
  CHECK(report.own_constants);
  CHECK(report.infrared);
  CHECK(report.frames == 10);
  CHECK(report.starts == 1);
}

TEST_CASE("depth through the wire is the depth of the mock camera to the millimetre", "[camera][emulated]") {
  CameraRig rig(std::nullopt);
  REQUIRE(rig.camera.configure());
  REQUIRE(rig.camera.activate());
  const auto frame = rig.camera.next_frame(2s);
  REQUIRE(frame);
  const auto truth = sim_hal::cast_rays(CameraRig::world(0.0), hal::CameraIntrinsics{}, rig.X_WC);
  std::size_t seen = 0, off = 0;
  for (std::size_t i = 0; i < truth.depth_m.size(); ++i) {
    const float z = truth.depth_m[i], got = frame->depth_m[i];
    if (!(z > 0.45f && z < 9.0f)) continue;
    ++seen;
    const float step = z * z / 345.5f + 0.002f;  // one code
    off += !(std::abs(got - z) <= step);
  }
  CHECK(seen > 100'000);
  CHECK(off == 0);
}

TEST_CASE("infrared comes beside the depth when it is wanted", "[camera][emulated]") {
  CameraRig rig;
  REQUIRE(rig.camera.configure());
  REQUIRE(rig.camera.activate());
  CHECK_FALSE(rig.camera.next_infrared(10ms));
  REQUIRE(rig.camera.want_infrared(true));
  const auto image = rig.camera.next_infrared(2s);
  INFO((image ? "" : image.error().text()));
  REQUIRE(image);
  CHECK(image->width == 640);
  CHECK(image->height == 488);
  REQUIRE(image->brightness.size() == 640UL * 488);
  CHECK(image->intrinsics.cx == Approx(325.0));
  CHECK(rig.camera.next_frame(2s));
  // also of the process that follows one that was killed
  REQUIRE(::kill(rig.camera.report().pid, SIGKILL) == 0);
  REQUIRE(rig.until([&] {
    const auto lost = rig.camera.next_infrared(0ms);
    return !lost && lost.error().code == hal::ErrorCode::LinkLost;
  }));
  CHECK(rig.until([&] { return rig.camera.next_infrared(0ms).has_value(); }));
  CHECK(rig.camera.report().starts == 2);
  REQUIRE(rig.camera.want_infrared(false));
  CHECK_FALSE(rig.camera.next_infrared(10ms));
}

TEST_CASE("the motor turns within its limits only, and only when it was opened", "[camera][emulated]") {
  CameraRig rig;
  CHECK(rig.camera.tilt(5.0).error().code == hal::ErrorCode::NotReady);
  REQUIRE(rig.camera.configure());
  CHECK(rig.camera.tilt(40.0).error().code == hal::ErrorCode::LimitExceeded);
  REQUIRE(rig.camera.tilt(12.0));
  CHECK(rig.until([&] { return rig.server.report().tilt_deg == 12.0; }));
}

TEST_CASE("a camera that is not there is said, and found when it comes", "[camera][emulated][faults]") {
  CameraRig rig(sim_hal::KinectNoise{}, {"0:unplug:1.0"});
  const auto open = rig.camera.configure();
  REQUIRE_FALSE(open);
  CHECK(open.error().code == hal::ErrorCode::LinkLost);
  CHECK_THAT(open.error().detail, Catch::Contains("no Kinect"));
  CHECK(rig.until([&] { return rig.camera.configure().has_value(); }));
}

TEST_CASE("a capture process that is killed or stopped costs the camera, and the camera comes back",
          "[camera][emulated][faults]") {
  const int signal = GENERATE(SIGKILL, SIGSTOP, SIGSEGV);
  CameraRig rig;
  REQUIRE(rig.camera.configure());
  REQUIRE(rig.camera.activate());
  REQUIRE(rig.camera.next_frame(2s));
  const pid_t first = rig.camera.report().pid;
  REQUIRE(first > 0);
  REQUIRE(::kill(first, signal) == 0);
  const auto lost = rig.until_error();
  INFO(lost.text());
  CHECK(lost.code == hal::ErrorCode::LinkLost);
  if (signal == SIGKILL) CHECK_THAT(lost.detail, Catch::Contains("signal 9"));
  if (signal == SIGSTOP) CHECK_THAT(lost.detail, Catch::Contains("no frame for"));
  CHECK(rig.camera.health().state == hal::DeviceHealth::State::Lost);
  REQUIRE(rig.until([&] { return rig.camera.next_frame(0ms).has_value(); }));
  const hal::KinectReport report = rig.camera.report();
  CHECK(report.pid != first);
  CHECK(report.starts >= 2);
  CHECK(report.kills == (signal == SIGSTOP ? 1u : 0u));
  CHECK(::kill(first, 0) != 0);  // nothing of it is left
}

TEST_CASE("a library that hangs in a call is killed with its process", "[camera][emulated][faults]") {
  CameraRig rig;
  REQUIRE(rig.camera.configure());
  REQUIRE(rig.camera.activate());
  REQUIRE(rig.camera.next_frame(2s));
  rig.fault("0:hang:600");
  CHECK(rig.until_error().code == hal::ErrorCode::LinkLost);
  REQUIRE(rig.until([&] { return rig.camera.next_frame(0ms).has_value(); }));
  CHECK(rig.camera.report().kills == 1);
}

TEST_CASE("a library that crashes says so in the camera's words", "[camera][emulated][faults]") {
  CameraRig rig;
  REQUIRE(rig.camera.configure());
  REQUIRE(rig.camera.activate());
  REQUIRE(rig.camera.next_frame(2s));
  rig.fault("0:crash");
  CHECK_THAT(rig.until_error().detail, Catch::Contains("signal 11"));
  CHECK(rig.until([&] { return rig.camera.next_frame(0ms).has_value(); }));
}

TEST_CASE("unplugged and plugged in again", "[camera][emulated][faults]") {
  CameraRig rig;
  REQUIRE(rig.camera.configure());
  REQUIRE(rig.camera.activate());
  REQUIRE(rig.camera.next_frame(2s));
  rig.fault("0:unplug:1.0");
  const auto lost = rig.until_error();
  CHECK(lost.code == hal::ErrorCode::LinkLost);
  REQUIRE(rig.until([&] { return rig.camera.next_frame(0ms).has_value(); }));
}

TEST_CASE("frames with lost packets are known and dropped", "[camera][emulated][faults]") {
  CameraRig rig;
  REQUIRE(rig.camera.configure());
  REQUIRE(rig.camera.activate());
  REQUIRE(rig.camera.next_frame(2s));
  rig.fault("0:packets=3:0.5");
  CHECK(rig.until([&] {
    (void)rig.camera.next_frame(0ms);
    return rig.camera.report().suspect >= 3;
  }));
  CHECK(rig.camera.report().lost_packets >= 9);
  CHECK(rig.until([&] { return rig.camera.next_frame(0ms).has_value(); }));
}

TEST_CASE("frames that come twice, in the wrong order or under an old time are dropped",
          "[camera][emulated][faults]") {
  const char* fault = GENERATE("0:double:600", "0:swap:600", "0:restamp:600");
  CameraRig rig;
  REQUIRE(rig.camera.configure());
  REQUIRE(rig.camera.activate());
  REQUIRE(rig.camera.next_frame(2s));
  rig.fault(fault);
  hal::Timestamp last = hal::Timestamp::min();
  bool ordered = true;
  CHECK(rig.until([&] {
    if (const auto frame = rig.camera.next_frame(0ms)) {
      ordered = ordered && frame->exposed_at > last;
      last = frame->exposed_at;
    }
    return rig.camera.report().old >= 3;
  }));
  CHECK(ordered);
}
