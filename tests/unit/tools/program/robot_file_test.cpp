// Robot files: a device and how it is reached, in one group or in two.

#include <catch2/catch.hpp>
#include <string>

#include "tests/support/temporary_folder.hpp"
#include "tools/rig/robot_file.hpp"

namespace {

using namespace colift;

hal::Result<tools::RobotFile> read(const std::string& text) {
  const tests::TemporaryFolder folder;
  return tools::read_robot_file(folder.write("robot.yaml", text));
}

}  // namespace

TEST_CASE("a device's driver and its settings may stand in one group", "[robot-file]") {
  const auto one = read(
      "camera: {driver: ros2, image: /cam/image, info: /cam/info}\n"
      "hand: {driver: barrett, can: \"socketcan:can1\"}\n"
      "arm: {driver: simulated}\n"
      "more_cameras:\n  - camera: {driver: v4l2, device: /dev/video4}\n    calibration: side.yaml\n");
  INFO((one ? std::string() : one.error().text()));
  REQUIRE(one);
  CHECK(one->camera == "ros2");
  CHECK(one->ros2.image == "/cam/image");
  CHECK(one->ros2.info == "/cam/info");
  CHECK(one->hand == "barrett");
  CHECK(one->barrett.can == "socketcan:can1");
  CHECK(one->arm == "simulated");
  REQUIRE(one->more_cameras.size() == 1);
  CHECK(one->more_cameras[0].camera == "v4l2");
  CHECK(one->more_cameras[0].v4l2.device == "/dev/video4");
  CHECK(one->more_cameras[0].calibration == "side.yaml");

  const auto two = read("camera: ros2\nros2: {image: /cam/image, info: /cam/info}\n");
  REQUIRE(two);
  CHECK(two->ros2.image == one->ros2.image);
}

TEST_CASE("what is wrong in such a group is refused with its place", "[robot-file]") {
  struct Case {
    const char *text, *says;
  };
  for (const auto& [text, says] :
       {Case{"camera: {driver: ross, image: /a}\n", "robot.yaml:1:18"},
        Case{"camera: {image: /a}\n", "robot.yaml:1:9"}, Case{"camera: {driver: [ros2]}\n", "robot.yaml:1:9"},
        Case{"camera: {driver: ros2, imge: /a}\n", "did you mean \"ros2.image\"?"},
        Case{"camera: {driver: ros2, driver: kinect}\n", "driver"},
        Case{"arm: {driver: simulated, port: 3}\n", "simulated"},
        Case{"camera: {driver: ros2, image: /a}\nros2: {image: /b}\n", "given twice"},
        Case{"- camera\n", "robot.yaml"}}) {
    const auto file = read(text);
    INFO(text << (file ? std::string() : file.error().text()));
    REQUIRE_FALSE(file);
    CHECK(file.error().code == hal::ErrorCode::BadConfig);
    CHECK(file.error().text().find(says) != std::string::npos);
  }
}
