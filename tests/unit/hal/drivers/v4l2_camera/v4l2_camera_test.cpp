#include "hal/drivers/v4l2_camera/v4l2_camera.hpp"

#include <linux/videodev2.h>

#include <catch2/catch.hpp>
#include <cerrno>

#include "hal/guards/guarded_camera.hpp"
#include "hal/os/video_kernel.hpp"
#include "tests/support/video_rig.hpp"

// The whole driver with its thread, in real time: every wait ends with what is waited for.
namespace colift::tests {
namespace {

using namespace std::chrono_literals;
using hal::ErrorCode;
using State = hal::DeviceHealth::State;

void open(hal::DepthCamera& camera) {
  if (auto done = camera.configure(); !done) FAIL(done.error().text());
  REQUIRE(camera.activate());
}

/// Until its health says it, for half a minute at most.
template <class Condition>
bool health_until(VideoRig& rig, const Condition& condition) {
  const hal::Timestamp end = rig.clock.now() + 30s;
  while (!condition(rig.camera.health())) {
    if (rig.clock.now() > end) return false;
    (void)rig.camera.next_frame(5ms);
  }
  return true;
}

sim_hal::EmulatedVideo::Lie fails(unsigned long wanted, int error_number) {
  return [=](unsigned long request, void*) -> std::optional<int> {
    if (request == wanted) return -error_number;
    return std::nullopt;
  };
}

}  // namespace

TEST_CASE("a frame over V4L2 has the model of the file, the kernel's time and metres", "[v4l2][camera]") {
  VideoRig rig;
  open(rig.camera);
  const auto frame = rig.camera.next_frame(10s);
  REQUIRE(frame);
  CHECK(frame->intrinsics.width == 160);
  CHECK(frame->intrinsics.fy == 151.0);
  CHECK(frame->exposed_at <= rig.clock.now());
  CHECK(frame->depth_m[60 * 160 + 80] == Approx(1.33f).margin(0.2f));
}

TEST_CASE("what was measured between exposure and stamp is taken off the time", "[v4l2][camera]") {
  auto config = video_config();
  config.latency_ms = 250.0;
  VideoRig rig({}, config);
  open(rig.camera);
  const auto frame = rig.camera.next_frame(10s);
  REQUIRE(frame);
  CHECK(rig.clock.now() - frame->exposed_at >= 250ms);
}

TEST_CASE("a device that cannot be used ends configure() with its sentence", "[v4l2][camera]") {
  SECTION("another path: there is none") {
    auto config = video_config();
    config.device = "/dev/video7";
    VideoRig rig({}, config);
    const auto opened = rig.camera.configure();
    REQUIRE_FALSE(opened);
    CHECK(opened.error().code == ErrorCode::LinkLost);
    CHECK_THAT(opened.error().detail, Catch::Contains("there is no /dev/video7"));
    CHECK(rig.camera.health().state == State::Failed);
  }
  SECTION("another program has it; when that has ended, it opens") {
    VideoRig rig;
    rig.device->lie(fails(VIDIOC_S_FMT, EBUSY));
    const auto opened = rig.camera.configure();
    REQUIRE_FALSE(opened);
    CHECK(opened.error().code == ErrorCode::DeviceFault);
    CHECK_THAT(opened.error().detail, Catch::Contains("another program"));
    rig.device->lie({});
    open(rig.camera);
    CHECK(rig.camera.next_frame(10s));
    CHECK(rig.device->report().broken_rules.empty());
  }
  SECTION("stamps of another clock") {
    auto config = video_config();
    config.frames_s = 0.3;
    VideoRig rig({"0:foreign:1000"}, config);
    const auto opened = rig.camera.configure();
    REQUIRE_FALSE(opened);
    CHECK_THAT(opened.error().detail, Catch::Contains("monotonic clock") && Catch::Contains("time: arrival"));
    CHECK(rig.camera.health().accepted == 0);
  }
  SECTION("silent from the start") {
    auto config = video_config();
    config.open_s = 0.3;
    VideoRig rig({"0:silent:1000"}, config);
    const auto opened = rig.camera.configure();
    REQUIRE_FALSE(opened);
    CHECK_THAT(opened.error().detail, Catch::Contains("no good frame of /dev/video0"));
  }
  SECTION("a model that cannot be: the device is not even opened") {
    hal::SteadyClock clock;
    const auto device =
        std::make_shared<sim_hal::EmulatedVideo>(video_device(), box_source(clock, std::nullopt), clock);
    auto model = video_model();
    model.unit_m = 0.0;
    hal::V4l2Camera camera(video_config(), model, device, clock);
    const auto opened = camera.configure();
    REQUIRE_FALSE(opened);
    CHECK(opened.error().code == ErrorCode::BadConfig);
    CHECK(device->report().opened == 0);
  }
}

TEST_CASE("with time: arrival a device without stamps can be used", "[v4l2][camera]") {
  auto config = video_config();
  config.time = "arrival";
  VideoRig rig({"0:foreign:1000"}, config);
  open(rig.camera);
  CHECK(rig.camera.next_frame(10s));
}

TEST_CASE("an unplugged camera is lost at once, and gives frames again when it is back", "[v4l2][camera]") {
  VideoRig rig;
  open(rig.camera);
  REQUIRE(rig.camera.next_frame(10s));
  rig.fault("0:unplug:1");
  const auto lost = rig.until(false);
  REQUIRE_FALSE(lost);
  CHECK(lost.error().code == ErrorCode::LinkLost);
  CHECK_THAT(lost.error().detail, Catch::Contains("gone") || Catch::Contains("there is no"));
  CHECK(rig.camera.health().state == State::Lost);
  const auto again = rig.camera.configure();
  if (!again) CHECK(again.error().code == ErrorCode::LinkLost);  // and it did not wait
  CHECK(rig.until(true));
  CHECK(rig.camera.configure());
  CHECK(rig.device->report().opened == 2);
}

TEST_CASE("a silent device is lost, and is opened anew", "[v4l2][camera]") {
  auto config = video_config();
  config.silent_s = 0.3;
  config.frames_s = 0.6;
  VideoRig rig({}, config);
  open(rig.camera);
  REQUIRE(rig.until(true));
  rig.fault("0:silent:2");
  const auto lost = rig.until(false);
  REQUIRE_FALSE(lost);
  CHECK(lost.error().code == ErrorCode::LinkLost);
  CHECK_THAT(lost.error().detail, Catch::Contains("no good frame"));
  CHECK(rig.until(true));
  CHECK(rig.device->report().opened >= 2);
  CHECK(rig.device->report().broken_rules.empty());
}

TEST_CASE("a call that does not come back is named, and does not hold the caller", "[v4l2][camera]") {
  auto config = video_config();
  config.silent_s = 0.3;
  VideoRig rig({}, config);
  open(rig.camera);
  REQUIRE(rig.until(true));
  rig.fault("0:hang:2");
  const auto lost = rig.until(false);
  REQUIRE_FALSE(lost);
  CHECK(lost.error().code == ErrorCode::LinkLost);
  CHECK_THAT(lost.error().detail, Catch::Contains("has not come back from VIDIOC_"));
  CHECK(rig.until(true));
}

TEST_CASE("a camera whose call hangs can be destroyed", "[v4l2][camera]") {
  hal::SteadyClock clock;
  std::weak_ptr<sim_hal::EmulatedVideo> left;
  {
    const auto device =
        std::make_shared<sim_hal::EmulatedVideo>(video_device(), box_source(clock, std::nullopt), clock);
    left = device;
    hal::V4l2Camera camera(video_config(), video_model(), device, clock);
    open(camera);
    REQUIRE(camera.next_frame(10s));
    device->inject(sim_hal::parse_video_fault("0:hang:2").value());
  }
  // the thread that was left behind lets go of the device when the call has come back
  const hal::Timestamp end = clock.now() + 30s;
  while (!left.expired() && clock.now() < end) std::this_thread::sleep_for(2ms);
  CHECK(left.expired());
}

TEST_CASE("images with what is wrong in them are dropped, counted and named; good ones follow",
          "[v4l2][camera]") {
  for (const auto& [fault, expected] :
       {std::pair{"0:damaged:0.4", "damaged"}, std::pair{"0:short=30:0.4", "bytes"},
        std::pair{"0:jump=8000:0.4", "in the future"}, std::pair{"0:jump=-8000:0.4", "old by its stamp"},
        std::pair{"0:restamp:0.4", "older than the one before"},
        std::pair{"0:foreign:0.4", "not of the monotonic clock"}}) {
    INFO(fault);
    VideoRig rig;
    open(rig.camera);
    REQUIRE(rig.camera.next_frame(10s));
    rig.fault(fault);
    CHECK(health_until(rig, [](const auto& h) { return h.rejected > 0; }));
    CHECK_THAT(rig.camera.health().last_error, Catch::Contains(expected));
    const auto before = rig.camera.health().accepted;
    CHECK(health_until(rig, [&](const auto& h) { return h.accepted > before; }));
  }
}

TEST_CASE("behind its guard the same picture, no picture and late ones are a lost camera", "[v4l2][camera]") {
  for (const auto& [fault, expected] :
       {std::pair{"0:freeze:100", "the same picture"}, std::pair{"0:blind:100", "shows nothing"},
        std::pair{"0:late=900:100", "old when they come"}}) {
    INFO(fault);
    hal::SteadyClock clock;
    const auto device = std::make_shared<sim_hal::EmulatedVideo>(
        video_device(), box_source(clock, sim_hal::KinectNoise{}), clock);
    hal::CameraGuardConfig guard;
    guard.silent_s = 20.0;  // a test machine may be busy
    guard.max_age_s = 0.5;
    hal::GuardedCamera camera(std::make_unique<hal::V4l2Camera>(video_config(), video_model(), device, clock),
                              guard, clock);
    open(camera);
    device->inject(sim_hal::parse_video_fault(fault).value());
    hal::Result<hal::DepthFrame> frame = hal::DepthFrame{};
    const hal::Timestamp end = clock.now() + 30s;
    while ((frame || frame.error().code != ErrorCode::LinkLost) && clock.now() < end)
      frame = camera.next_frame(20ms);
    REQUIRE_FALSE(frame);
    CHECK_THAT(frame.error().detail, Catch::Contains(expected));
    CHECK(camera.health().state == State::Lost);
  }
}

TEST_CASE("the kernel's own calls: what is no video device is refused in words", "[v4l2][camera]") {
  const auto kernel = std::shared_ptr<hal::VideoCalls>(hal::make_video_kernel());
  hal::SteadyClock clock;
  for (const auto& [path, code, expected] :
       {std::tuple{"/dev/video-that-there-is-not", ErrorCode::LinkLost, "there is no"},
        std::tuple{"/dev/null", ErrorCode::BadConfig, "is no video device"},
        std::tuple{"/", ErrorCode::BadConfig, "is no device"}}) {
    auto config = video_config();
    config.device = path;
    hal::V4l2Camera camera(config, video_model(), kernel, clock);
    const auto opened = camera.configure();
    REQUIRE_FALSE(opened);
    INFO(opened.error().text());
    CHECK(opened.error().code == code);
    CHECK_THAT(opened.error().detail, Catch::Contains(expected));
  }
}

}  // namespace colift::tests
