#include "sim_hal/emulator/camera/camera_faults.hpp"

#include <catch2/catch.hpp>

using namespace colift;
using namespace colift::sim_hal;

TEST_CASE("a fault of the camera is read or refused in words", "[camera][emulator]") {
  const auto f = parse_camera_fault("4.0:slow=10:2.5");
  REQUIRE(f);
  CHECK((f->kind == CameraFault::Kind::Slow && f->at_s == 4.0 && f->value == 10.0 && f->for_s == 2.5));
  CHECK(parse_camera_fault("1:slow")->value == 5.0);
  CHECK(parse_camera_fault("1:drop")->kind == CameraFault::Kind::Silent);
  for (const auto& [text, part] : std::vector<std::pair<std::string, std::string>>{
           {"slow", "expected T:KIND"},
           {"1:estop", "no fault of the camera; there are unplug, silent"},
           {"1:blind=3", "blind takes no value"},
           {"1:slow=30", "the value of slow is \"30\", expected a number from 0.5 to 29"},
           {"1:half=50%", "the value of half"},
       }) {
    CAPTURE(text);
    const auto bad = parse_camera_fault(text);
    REQUIRE_FALSE(bad);
    CHECK(bad.error().code == hal::ErrorCode::BadInput);
    CHECK(bad.error().text().find(part) != std::string::npos);
  }
}

TEST_CASE("a device has its faults from the scenario, then those of the command line", "[camera][emulator]") {
  const std::vector<DeviceFaultEvent> events{{2.0, "arm", "estop", 1.0}, {3.0, "camera", "blind", 0.5}};
  const auto faults = faults_of("camera", events, {"1:freeze"}, camera_fault, parse_camera_fault);
  REQUIRE(faults);
  REQUIRE(faults->size() == 2);
  CHECK((*faults)[0].kind == CameraFault::Kind::Blind);
  CHECK((*faults)[1].kind == CameraFault::Kind::Freeze);
  CHECK_FALSE((*faults)[0].active(2.9));
  CHECK((*faults)[0].active(3.4));
  CHECK_FALSE((*faults)[0].active(3.5));

  const auto of_scenario =
      faults_of("camera", {{3.0, "camera", "estop", 0.5}}, {"1:freeze"}, camera_fault, parse_camera_fault);
  REQUIRE_FALSE(of_scenario);
  CHECK(of_scenario.error().code == hal::ErrorCode::BadConfig);
  const auto typed = faults_of("camera", events, {"1:estop"}, camera_fault, parse_camera_fault);
  REQUIRE_FALSE(typed);
  CHECK(typed.error().code == hal::ErrorCode::BadInput);
}
