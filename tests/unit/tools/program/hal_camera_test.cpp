// Bring-up of a depth camera that is no Kinect.
#include <catch2/catch.hpp>
#include <filesystem>
#include <fstream>

#include "hal/drivers/recorded/recorded_camera.hpp"
#include "sim_hal/mock/mock_camera.hpp"
#include "tests/support/temporary_folder.hpp"
#include "tools/bring_up/camera/depth_camera_watch.hpp"
#include "tools/bring_up/camera/openni2_command.hpp"
#include "tools/rig/openni2_rig.hpp"
#include "tools/rig/video_rig.hpp"

namespace colift {
using namespace tools;
namespace {

namespace fs = std::filesystem;

constexpr auto kIntrinsics =
    R"({"width": 160, "height": 120, "fx": 150, "fy": 150, "cx": 80, "cy": 60, "depth_scale_m": 0.00025})";

sim_hal::CameraScript floor_and_box() {
  sim_hal::CameraScript s;
  s.world = [](std::uint64_t) {
    sim_hal::World w;
    w.shapes.push_back(sim_hal::half_space(hal::Vec3::Zero(), hal::Vec3::UnitZ(), sim_hal::Label::Ground));
    w.shapes.push_back(sim_hal::box({0, 0, 0.2}, {0.4, 0.4, 0.4}, 0.3, sim_hal::Label::Target));
    return w;
  };
  s.intrinsics = {160, 120, 150.0, 150.0, 80.0, 60.0};
  s.X_WC = sim_hal::look_at({-1.2, 0, 1.2}, {0, 0, 0.2});
  return s;
}

HalCameraOptions asks(const char* verb) {
  HalCameraOptions o;
  o.hal.verb = verb;
  return o;
}

CommonOptions silently() {
  CommonOptions common;
  common.quiet = true;
  common.json = true;
  return common;
}

}  // namespace

TEST_CASE("a camera of V4L2 is asked with words that help for what it has not", "[program]") {
  const tests::TemporaryFolder scratch;
  const auto robot = [&](const std::string& v4l2) {
    return scratch.write("rig.yaml", "arm: fri\nhand: barrett\ncamera: v4l2\nv4l2: {" + v4l2 + "}\n");
  };
  const std::string with = "intrinsics: " + scratch.write("camera.json", kIntrinsics).string() + ", device: ";
  HalCameraOptions o = asks("info");
  o.hal.robot = robot("device: /dev/null");
  CHECK(cmd_hal_camera(silently(), o) == kBadInput);  // no intrinsics
  o.hal.robot = robot(with + "/dev/null");
  CHECK(cmd_hal_camera(silently(), o) == kBadInput);  // no video device
  o.hal.robot = robot(with + "/dev/video-that-there-is-not");
  CHECK(cmd_hal_camera(silently(), o) == kDeviceFailed);
  for (const char* verb : {"tilt", "record"}) CHECK_FALSE(check_depth_camera_request(asks(verb)));
  o = asks("info");
  CHECK(check_depth_camera_request(o));
  o.infrared = "ir.png";
  CHECK_FALSE(check_depth_camera_request(o));
  o = asks("watch");
  o.source = "usb";
  CHECK_FALSE(check_depth_camera_request(o));
}

TEST_CASE("intrinsics of a V4L2 camera come from its file, or it is refused", "[program]") {
  const tests::TemporaryFolder scratch;
  hal::V4l2CameraConfig config;
  config.intrinsics = scratch.write("camera.json", kIntrinsics);
  const auto model = depth_model(config);
  REQUIRE(model);
  CHECK(model->intrinsics.width == 160);
  CHECK(model->unit_m == 0.00025);
  config.depth_unit_m = 0.001;
  CHECK(depth_model(config)->unit_m == 0.001);
  const auto refused = [&](const std::string& text, const char* expected) {
    config.intrinsics = scratch.write("wrong.json", text);
    const auto wrong = depth_model(config);
    REQUIRE_FALSE(wrong);
    CHECK(wrong.error().code == hal::ErrorCode::BadConfig);
    CHECK_THAT(wrong.error().detail, Catch::Contains(expected));
  };
  refused("{", "wrong.json:1");
  refused(R"({"fx": 150, "fy": 150, "cx": 80, "cy": 60, "depth_scale_m": 0.001})", "no width and height");
  refused(R"({"width": 160, "height": 120, "fx": 5, "fy": 150, "cx": 80, "cy": 60, "depth_scale_m": 0.001})",
          "focal");
  config.intrinsics = scratch.path() / "missing.json";
  CHECK_FALSE(depth_model(config));
  config.intrinsics.clear();
  CHECK_THAT(depth_model(config).error().detail, Catch::Contains("names no file"));
}

TEST_CASE("a camera of OpenNI2 is named by the robot file, or by --source alone", "[program]") {
  const tests::TemporaryFolder scratch;
  HalCameraOptions o = asks("info");
  CHECK_FALSE(openni2_of(o));
  o.source = "usb";
  CHECK_FALSE(openni2_of(o));
  o.source = "openni2:file:a.oni";
  REQUIRE(openni2_of(o));
  CHECK(openni2_of(o)->source == "file:a.oni");
  o.hal.robot = scratch.write("rig.yaml", "camera: {driver: openni2, source: 'uri:x', unit: 100um}\n");
  CHECK(openni2_of(o)->source == "file:a.oni");
  o.source = "any";
  CHECK(openni2_of(o)->source == "any");
  o.source.clear();
  CHECK(openni2_of(o)->source == "uri:x");
  CHECK(openni2_of(o)->unit == "100um");
  o.hal.robot = scratch.write("other.yaml", "camera: kinect\n");
  CHECK_FALSE(openni2_of(o));
}

TEST_CASE("a camera of OpenNI2 is asked with words that help for what it has not", "[program]") {
  const tests::TemporaryFolder scratch;
  HalCameraOptions o = asks("info");
  for (const char* source : {"openni2:", "openni2:usb", "openni2:file:/no/such.oni"}) {
    o.source = source;
    CHECK(cmd_hal_camera(silently(), o) == kBadInput);
  }
  o = asks("record");
  o.source = "openni2:any";
  for (const char* name : {"folder", "rig.yaml"}) {
    o.folder = scratch.path() / name;
    CHECK(cmd_hal_camera(silently(), o) == kBadInput);
  }
  o.folder = scratch.write("there.oni", "x");
  CHECK(cmd_hal_camera(silently(), o) == kBadInput);
  o = asks("tilt");
  o.source = "openni2:any";
  o.hal.yes = true;
  CHECK(cmd_hal_camera(silently(), o) == kBadInput);
}

TEST_CASE("intrinsics of a camera of OpenNI2 come from its file where one is named", "[program]") {
  const tests::TemporaryFolder scratch;
  const hal::ManualClock clock;
  hal::Openni2CameraConfig config;
  CHECK(make_openni2_camera(config, clock));
  config.intrinsics = scratch.write("camera.json", kIntrinsics);
  CHECK(make_openni2_camera(config, clock));
  config.height = 120;
  CHECK(make_openni2_camera(config, clock));
  const auto refused = [&](const char* expected) {
    const auto wrong = make_openni2_camera(config, clock);
    REQUIRE_FALSE(wrong);
    CHECK(wrong.error().code == hal::ErrorCode::BadConfig);
    CHECK_THAT(wrong.error().detail, Catch::Contains(expected));
  };
  config.width = 640;
  refused("160 x 120");
  config.width = 0;
  config.intrinsics =
      scratch.write("wrong.json", R"({"fx": 150, "fy": 150, "cx": 80, "cy": 60, "depth_scale_m": 0.001})");
  refused("no width and height");
  config.intrinsics = scratch.path() / "missing.json";
  refused("missing.json");
}

TEST_CASE("what a depth camera shows can be kept and read again; its noise too", "[program]") {
  const tests::TemporaryFolder scratch;
  hal::ManualClock clock;
  sim_hal::MockCamera camera(floor_and_box(), clock);
  HalCameraOptions o = asks("info");
  o.depth = scratch.path() / "depth.png";
  o.png = scratch.path() / "picture.png";
  CHECK(watch_depth_camera(silently(), o, {camera, "mock", "nothing", {}}, clock, 0.5, {}) == kDone);
  CHECK(fs::exists(*o.png));
  hal::RecordedCamera kept(hal::RecordedCameraConfig{scratch.path().string(), 0.25, true});
  REQUIRE(kept.configure());
  REQUIRE(kept.activate());
  const auto frame = kept.next_frame(std::chrono::milliseconds(100));
  REQUIRE(frame);
  CHECK(frame->intrinsics.fx == 150.0);
  CHECK(frame->depth_m.size() == 160 * 120);

  o = asks("noise");
  o.out = scratch.path() / "noise.yaml";
  sim_hal::MockCamera floor(floor_and_box(), clock);
  CHECK(watch_depth_camera(silently(), o, {floor, "mock", "nothing", {}}, clock, 1.0, {}) == kDone);
  CHECK(fs::file_size(*o.out) > 50);
}

}  // namespace colift
