// The same capture process, unchanged, on Debian's fakenect library, which plays recordings.

#include <catch2/catch.hpp>
#include <cmath>

#include "hal/drivers/kinect/kinect_camera.hpp"
#include "hal/drivers/recorded/frame_file.hpp"
#include "tests/support/fakenect_folder.hpp"

using namespace colift;
using namespace std::chrono_literals;
using tests::FakenectFolder;

namespace {

constexpr std::uint32_t kFrame = 2'000'000;  // ticks

/// Frames at 30 Hz that begin just before the counter wraps.
void record(FakenectFolder& folder, int frames) {
  for (int i = 0; i < frames; ++i) {
    const std::uint32_t ticks = 4293967296u + static_cast<std::uint32_t>(i) * kFrame;
    folder.depth(1000.0 + i / 30.0, ticks);
    folder.accelerometer(1000.002 + i / 30.0, ticks);
  }
}

hal::KinectConfig config_of(const FakenectFolder& folder) {
  hal::KinectConfig config;
  config.source = "fakenect:" + folder.path().string();
  config.motor = true;
  config.open_s = 20.0;
  return config;
}

}  // namespace

TEST_CASE("a recording is played through libfreenect's functions, up to its end", "[camera][fakenect]") {
  FakenectFolder folder;
  record(folder, 12);
  const hal::SteadyClock clock;
  hal::KinectCamera camera(config_of(folder), clock);
  REQUIRE(camera.configure());
  REQUIRE(camera.activate());
  std::vector<hal::DepthFrame> frames;
  hal::Error error{hal::ErrorCode::Timeout, "", ""};
  while (error.code == hal::ErrorCode::Timeout) {
    auto frame = camera.next_frame(5s);
    if (frame)
      frames.push_back(std::move(*frame));
    else
      error = frame.error();
  }
  CHECK(error.code == hal::ErrorCode::LinkLost);
  CHECK_THAT(error.detail, Catch::Contains("recording is over"));
  // a slow machine may lose some, each in its order, and the counter's wrap is none of its business
  REQUIRE(frames.size() >= 3);
  for (std::size_t i = 1; i < frames.size(); ++i) {
    const double step = hal::seconds(frames[i].exposed_at - frames[i - 1].exposed_at);
    CHECK(step > 0.02);
    CHECK(step < 0.5);
  }
  const hal::KinectReport report = camera.report();
  CHECK(report.frames + report.missed + report.suspect >= frames.size());
  CHECK(report.old == 0);
  CHECK_FALSE(report.own_constants);  // the library cannot tell
  CHECK_FALSE(report.infrared);
  CHECK(camera.want_infrared(true).error().code == hal::ErrorCode::DeviceFault);
  if (frames.back().up_C) CHECK((*frames.back().up_C + hal::Vec3::UnitY()).norm() < 0.01);

  // the same scene as a depth image says the same depths, to the last millimetre
  const auto png = hal::read_frame(
      std::string(COLIFT_TEST_DATA) + "/real/01_office_chair_and_bottles/depth.png", std::nullopt);
  REQUIRE(png);
  const auto& truth = png->frame.depth_m;
  REQUIRE(truth.size() == frames[0].depth_m.size());
  std::size_t seen = 0, off = 0;
  for (std::size_t i = 0; i < truth.size(); ++i) {
    if (std::isnan(truth[i])) continue;
    ++seen;
    off += !(std::abs(truth[i] - frames[0].depth_m[i]) < 1e-6f);
  }
  CHECK(seen > 200'000);
  CHECK(off == 0);
}

TEST_CASE("a recording begins anew when it is asked for", "[camera][fakenect]") {
  FakenectFolder folder;
  record(folder, 3);
  const hal::SteadyClock clock;
  hal::KinectCamera camera(config_of(folder), clock);
  for (int round = 0; round < 2; ++round) {
    REQUIRE(camera.configure());
    REQUIRE(camera.activate());
    int frames = 0;
    hal::ErrorCode code = hal::ErrorCode::Timeout;
    while (code == hal::ErrorCode::Timeout) {
      const auto frame = camera.next_frame(5s);
      if (frame)
        ++frames;
      else
        code = frame.error().code;
    }
    CHECK(frames >= 1);
    CHECK(code == hal::ErrorCode::LinkLost);
  }
}

TEST_CASE("one bad transfer is got over", "[camera][fakenect][faults]") {
  FakenectFolder folder;
  folder.depth(1000.0, 0);
  folder.bad_transfer(1000.033, kFrame);
  for (int i = 2; i < 8; ++i) folder.depth(1000.0 + i / 30.0, static_cast<std::uint32_t>(i) * kFrame);
  const hal::SteadyClock clock;
  hal::KinectCamera camera(config_of(folder), clock);
  REQUIRE(camera.configure());
  REQUIRE(camera.activate());
  hal::Timestamp first{0}, last{0};
  for (;;) {
    const auto frame = camera.next_frame(5s);
    if (!frame) {
      CHECK_THAT(frame.error().detail, Catch::Contains("recording is over"));
      break;
    }
    if (first == hal::Timestamp(0)) first = frame->exposed_at;
    last = frame->exposed_at;
  }
  CHECK(last > first);
  CHECK(camera.report().starts == 1);
}

TEST_CASE("a gap in a recording is a loss, and frames after it come again by themselves",
          "[camera][fakenect][faults]") {
  FakenectFolder folder;
  for (int i = 0; i < 4; ++i) folder.depth(1000.0 + i / 30.0, static_cast<std::uint32_t>(i) * kFrame);
  for (int i = 0; i < 10; ++i)
    folder.depth(1001.2 + i / 30.0, 70'000'000u + static_cast<std::uint32_t>(i) * kFrame);
  hal::KinectConfig config = config_of(folder);
  config.heartbeat_s = 20.0;  // the library sleeps through the gap
  const hal::SteadyClock clock;
  hal::KinectCamera camera(config, clock);
  REQUIRE(camera.configure());
  REQUIRE(camera.activate());
  bool lost = false, back = false;
  for (const hal::Timestamp end = clock.now() + 30s; clock.now() < end && !back;) {
    const auto frame = camera.next_frame(20ms);
    if (!frame && frame.error().code == hal::ErrorCode::LinkLost && !lost) {
      lost = true;
      CHECK_THAT(frame.error().detail, Catch::Contains("no frame for"));
    }
    back = lost && frame.has_value();
  }
  CHECK(lost);
  CHECK(back);
  CHECK(camera.report().starts == 1);
}

TEST_CASE("a camera that cannot be opened says what was looked for", "[camera][fakenect]") {
  const hal::SteadyClock clock;
  hal::KinectConfig config;
  const std::pair<std::string, std::string> bad[] = {{"fakenect:/nowhere", "INDEX.txt"},
                                                     {"fakenect:", "expected usb"},
                                                     {"webcam", "expected usb"},
                                                     {"usb:", "expected usb"}};
  for (const auto& [source, says] : bad) {
    config.source = source;
    hal::KinectCamera camera(config, clock);
    const auto done = camera.configure();
    REQUIRE_FALSE(done);
    CHECK(done.error().code == hal::ErrorCode::BadConfig);
    CHECK_THAT(done.error().detail, Catch::Contains(says));
  }
  config.source = "usb";
  config.program = "/nowhere/colift-kinect";
  hal::KinectCamera camera(config, clock);
  CHECK_THAT(camera.configure().error().detail, Catch::Contains("/nowhere/colift-kinect"));
}
