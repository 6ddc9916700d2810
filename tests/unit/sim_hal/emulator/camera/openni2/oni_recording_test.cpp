// Recordings that OpenNI2 writes itself, played as devices by OpenNI2 itself, through the same capture
// process.

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <fstream>

#include "tests/support/openni2_rig.hpp"
#include "tests/support/temporary_folder.hpp"

using namespace colift;
using namespace std::chrono_literals;
using tests::Openni2Rig;

namespace {

/// Records until `frames` were handed out; those frames.
std::vector<hal::DepthFrame> record(const std::filesystem::path& oni, std::size_t frames,
                                    const hal::Openni2CameraConfig& config = Openni2Rig::camera_config()) {
  Openni2Rig rig(sim_hal::KinectNoise{}, {}, config);
  rig.camera.record_to(oni);
  rig.open();
  std::vector<hal::DepthFrame> got;
  while (got.size() < frames) got.push_back(rig.frame());
  if (auto done = rig.camera.finish_recording(10s); !done) FAIL(done.error().text());
  return got;
}

bool same(const hal::DepthFrame& a, const hal::DepthFrame& b) {
  return std::equal(a.depth_m.begin(), a.depth_m.end(), b.depth_m.begin(), b.depth_m.end(),
                    [](float x, float y) { return x == y || (std::isnan(x) && std::isnan(y)); });
}

hal::Openni2CameraConfig player(const std::filesystem::path& oni) {
  auto config = Openni2Rig::camera_config();
  config.source = "file:" + oni.string();
  return config;
}

}  // namespace

TEST_CASE("a recording of OpenNI2 plays as the device that was recorded, and ends", "[openni2][oni]") {
  const tests::TemporaryFolder folder;
  const auto oni = folder.path() / "box.oni";
  const auto recorded = record(oni, 12);
  hal::SteadyClock clock;
  hal::Openni2Camera camera(player(oni), std::nullopt, clock);
  // a recording that is over begins anew with configure()
  for (int round = 0; round < 2; ++round) {
    if (auto open = camera.configure(); !open) FAIL(open.error().text());
    REQUIRE(camera.activate());
    std::vector<hal::DepthFrame> played;
    hal::Result<hal::DepthFrame> next = hal::failure(hal::ErrorCode::Timeout, "", "");
    const hal::Timestamp end = clock.now() + 30s;
    do {
      next = camera.next_frame(20ms);
      if (next) played.push_back(*next);
    } while ((next || next.error().code == hal::ErrorCode::Timeout) && clock.now() < end);
    REQUIRE_FALSE(next);
    CHECK_THAT(next.error().detail, Catch::Contains("the recording is over"));
    // whoever is late gets the newest frame, so not each was handed out on both sides
    REQUIRE(played.size() >= 3);
    std::size_t found = 0;
    for (const auto& frame : recorded)
      found += std::any_of(played.begin(), played.end(), [&](const auto& p) { return same(p, frame); });
    CHECK(found >= 3);
    CHECK(played.front().intrinsics.fx == Approx(575.8).epsilon(1e-4));
    for (std::size_t i = 1; i < played.size(); ++i) CHECK(played[i].exposed_at > played[i - 1].exposed_at);
  }
}

TEST_CASE("a recording in tenths of a millimetre and of another size keeps both", "[openni2][oni]") {
  const tests::TemporaryFolder folder;
  auto config = Openni2Rig::camera_config();
  config.unit = "100um";
  config.width = 320;
  config.height = 240;
  const auto oni = folder.path() / "small.oni";
  const auto recorded = record(oni, 5, config);
  hal::SteadyClock clock;
  hal::Openni2Camera camera(player(oni), std::nullopt, clock);
  REQUIRE(camera.configure());
  REQUIRE(camera.activate());
  const auto frame = camera.next_frame(5s);
  INFO((frame ? "" : frame.error().text()));
  REQUIRE(frame);
  CHECK(frame->intrinsics.width == 320);
  CHECK(frame->intrinsics.fx == Approx(287.9).epsilon(1e-4));
  CHECK(std::any_of(frame->depth_m.begin(), frame->depth_m.end(), [](float z) { return z > 0.5f; }));
}

TEST_CASE("a recording that was mirrored is turned round", "[openni2][oni]") {
  const tests::TemporaryFolder folder;
  const auto oni = folder.path() / "box.oni";
  const auto recorded = record(oni, 8);
  // the property in the file: its name, the length of a value, the value
  std::fstream file(oni, std::ios::binary | std::ios::in | std::ios::out);
  std::string bytes(std::istreambuf_iterator<char>(file), {});
  const std::string name("xnMirror\0\x08\0\0\0", 13);
  const std::size_t at = bytes.find(name);
  REQUIRE(at != std::string::npos);
  REQUIRE(bytes[at + name.size()] == 0);
  file.clear();
  file.seekp(static_cast<std::streamoff>(at + name.size()));
  file.put(1);
  file.close();

  hal::SteadyClock clock;
  hal::Openni2Camera camera(player(oni), std::nullopt, clock);
  REQUIRE(camera.configure());
  REQUIRE(camera.activate());
  CHECK_THAT(camera.report().last_words, Catch::Contains("mirrored"));
  std::size_t found = 0;
  for (int i = 0; i < 5; ++i) {
    auto frame = camera.next_frame(1s);
    if (!frame) break;
    for (auto row = frame->depth_m.begin(); row != frame->depth_m.end(); row += 640)
      std::reverse(row, row + 640);
    found += std::any_of(recorded.begin(), recorded.end(), [&](const auto& r) { return same(*frame, r); });
  }
  CHECK(found >= 1);
}

TEST_CASE("a file that is no recording is refused, and costs nothing but its process", "[openni2][oni]") {
  const tests::TemporaryFolder folder;
  const auto oni = folder.path() / "none.oni";
  const std::string bytes =
      GENERATE(std::string(), std::string("NI10\0\0\0\0", 8), std::string(100'000, 'x'));
  std::ofstream(oni, std::ios::binary) << bytes;
  hal::SteadyClock clock;
  auto config = player(oni);
  config.open_s = 5.0;
  hal::Openni2Camera camera(config, std::nullopt, clock);
  const auto open = camera.configure();
  REQUIRE_FALSE(open);
  CHECK(open.error().code != hal::ErrorCode::BadConfig);
  INFO(open.error().text());
  CHECK_FALSE(open.error().detail.empty());
}

TEST_CASE("a recording that breaks off plays as far as it goes", "[openni2][oni]") {
  const tests::TemporaryFolder folder;
  const auto oni = folder.path() / "box.oni";
  (void)record(oni, 8);
  std::filesystem::resize_file(oni, std::filesystem::file_size(oni) / 2);
  hal::SteadyClock clock;
  auto config = player(oni);
  config.open_s = 5.0;
  hal::Openni2Camera camera(config, std::nullopt, clock);
  // whether OpenNI2 opens it is its own affair: it ends, with a sentence
  auto open = camera.configure();
  if (open) {
    REQUIRE(camera.activate());
    hal::Result<hal::DepthFrame> next = hal::failure(hal::ErrorCode::Timeout, "", "");
    const hal::Timestamp end = clock.now() + 30s;
    do next = camera.next_frame(20ms);
    while ((next || next.error().code == hal::ErrorCode::Timeout) && clock.now() < end);
    REQUIRE_FALSE(next);
    CHECK(next.error().code == hal::ErrorCode::LinkLost);
  } else {
    CHECK_FALSE(open.error().detail.empty());
  }
}

TEST_CASE("a recording is finished only where one is made", "[openni2][oni]") {
  Openni2Rig rig;
  CHECK(rig.camera.finish_recording(10ms).error().code == hal::ErrorCode::NotReady);
  rig.open();
  CHECK(rig.camera.finish_recording(10ms).error().code == hal::ErrorCode::NotReady);
}
