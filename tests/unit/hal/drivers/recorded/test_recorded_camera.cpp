#include <fmt/format.h>

#include <catch2/catch.hpp>

#include "hal/drivers/recorded/recorded_camera.hpp"
#include "writers.hpp"

using namespace colift::hal;
using namespace colift::hal::test;
using namespace std::chrono_literals;

namespace {

RecordedCamera started(RecordedCameraConfig config) {
  RecordedCamera camera(std::move(config));
  REQUIRE(camera.configure());
  REQUIRE(camera.activate());
  return camera;
}

std::string image_of(std::uint16_t depth_mm) {
  return png(8, 6, 16, false, false, std::vector<std::uint16_t>(48, depth_mm));
}

constexpr const char* kCamera = R"({"fx":10,"fy":10,"cx":4,"cy":3,"depth_scale_m":0.001})";

}  // namespace

TEST_CASE("a folder of depth images plays in order, one period apart, and then the camera is gone",
          "[recorded_camera][real]") {
  RecordedCamera camera = started({data("real/02_laptop_and_box").string(), 0.25, false});
  // the cloud beside the images is the first of them again
  REQUIRE(camera.files().size() == 3);
  for (int i = 0; i < 3; ++i) {
    const auto frame = camera.next_frame(0ms);
    REQUIRE(frame);
    CHECK(frame->exposed_at == i * 250ms);
    CHECK(frame->intrinsics.fx == 525.0);
  }
  const auto end = camera.next_frame(0ms);
  REQUIRE_FALSE(end);
  CHECK(end.error().code == ErrorCode::LinkLost);
  CHECK(end.error().detail == "the recording of 3 frames has ended");
  CHECK(camera.health().state == DeviceHealth::State::Lost);
  CHECK(camera.health().accepted == 3);
  // plugging it in again begins from the first frame
  REQUIRE(camera.configure());
  REQUIRE(camera.activate());
  CHECK(camera.next_frame(0ms)->exposed_at == 0ms);
}

TEST_CASE("numbers in names are sorted as numbers", "[recorded_camera]") {
  const TemporaryFolder folder;
  folder.write("camera.json", kCamera);
  for (const int i : {10, 9, 2, 100, 1})
    folder.write(fmt::format("depth_{}.png", i), image_of(static_cast<std::uint16_t>(1000 + i)));
  RecordedCamera camera = started({folder.path().string(), 0.1, false});
  for (const int i : {1, 2, 9, 10, 100}) {
    const auto frame = camera.next_frame(0ms);
    REQUIRE(frame);
    CHECK(frame->depth_m[0] == Approx(1.0 + 0.001 * i));
  }
}

TEST_CASE("a loop goes on with time that never runs backwards", "[recorded_camera]") {
  const TemporaryFolder folder;
  folder.write("camera.json", kCamera);
  folder.write("depth_0.png", image_of(1000));
  folder.write("depth_1.png", image_of(2000));
  RecordedCamera camera = started({folder.path().string(), 0.5, true});
  for (int i = 0; i < 7; ++i) {
    const auto frame = camera.next_frame(0ms);
    REQUIRE(frame);
    CHECK(frame->exposed_at == i * 500ms);
    CHECK(frame->depth_m[0] == (i % 2 == 0 ? 1.0f : 2.0f));
  }
}

TEST_CASE("a damaged frame is reported once and passed over", "[recorded_camera]") {
  const TemporaryFolder folder;
  folder.write("camera.json", kCamera);
  folder.write("depth_0.png", image_of(1000));
  folder.write("depth_1.png", image_of(2000).substr(0, 60));
  folder.write("depth_2.png", image_of(3000));
  RecordedCamera camera = started({folder.path().string(), 1.0, false});
  CHECK(camera.next_frame(0ms));
  const auto damaged = camera.next_frame(0ms);
  REQUIRE_FALSE(damaged);
  CHECK(damaged.error().code == ErrorCode::BadInput);
  CHECK(damaged.error().where.find("depth_1.png") != std::string::npos);
  const auto next = camera.next_frame(0ms);
  REQUIRE(next);
  CHECK(next->exposed_at == 2s);
  CHECK(camera.health().rejected == 1);
}

TEST_CASE("a loop over damaged frames alone ends", "[recorded_camera]") {
  const TemporaryFolder folder;
  folder.write("camera.json", kCamera);
  folder.write("depth_0.png", "no image");
  RecordedCamera camera = started({folder.path().string(), 1.0, true});
  CHECK(camera.next_frame(0ms).error().code == ErrorCode::BadInput);
  CHECK(camera.next_frame(0ms).error().code == ErrorCode::LinkLost);
}

TEST_CASE("a recording that is not there is a wrong configuration", "[recorded_camera]") {
  const TemporaryFolder folder;
  CHECK(RecordedCamera({folder.path().string(), 0.1, false}).configure().error().detail ==
        "the folder holds no depth*.png, *.pcd or *.ply");
  CHECK(RecordedCamera({(folder.path() / "none").string(), 0.1, false}).configure().error().detail ==
        "there is no such file or folder");
  CHECK(RecordedCamera({"", 0.1, false}).configure().error().code == ErrorCode::BadConfig);
  CHECK(RecordedCamera({folder.path().string(), 0.0, false}).configure().error().detail ==
        "period_s is 0; expected more than 0 and at most 3600 s");
}

TEST_CASE("a recorded camera gives no frame before it is activated, nor after it is deactivated",
          "[recorded_camera]") {
  RecordedCamera camera({data("real/02_laptop_and_box").string(), 0.25, false});
  CHECK(camera.activate().error().code == ErrorCode::NotReady);
  CHECK(camera.next_frame(0ms).error().code == ErrorCode::NotReady);
  REQUIRE(camera.configure());
  REQUIRE(camera.activate());
  camera.deactivate();
  CHECK(camera.next_frame(0ms).error().code == ErrorCode::NotReady);
}

TEST_CASE("a list of files plays in its own order", "[recorded_camera]") {
  const TemporaryFolder folder;
  folder.write("camera.json", kCamera);
  const auto a = folder.write("a.png", image_of(1000)), b = folder.write("b.png", image_of(2000));
  RecordedCamera camera({b, a}, RecordedCameraConfig{});
  REQUIRE(camera.configure());
  REQUIRE(camera.activate());
  CHECK(camera.next_frame(0ms)->depth_m[0] == 2.0f);
  CHECK(camera.next_frame(0ms)->depth_m[0] == 1.0f);
}
