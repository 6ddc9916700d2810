#include <catch2/catch.hpp>
#include <string>

#include "sim_hal/scenario/scenario.hpp"

using namespace colift::sim_hal;

namespace {

constexpr const char* kBox =
    "schema: colift.scenario/1\n"
    "object: {kind: box, size: [0.3, 0.3, 0.3], pose: {xyz: [1, 0, 0]}}\n"
    "partner: {kind: none}\n";

std::string refusal(const std::string& more) {
  const auto scenario = parse_scenario(kBox + more, "s.yaml");
  return scenario ? "accepted" : scenario.error().text();
}

}  // namespace

TEST_CASE("more cameras are read in their order, each with its own noise", "[scenario]") {
  const auto scenario = parse_scenario(std::string(kBox) +
                                           "more_cameras:\n"
                                           "  - {xyz: [0.3, 1.6, 1.5], look_at: [1, 0, 0.3]}\n"
                                           "  - {xyz: [2.3, 1.6, 1.5], look_at: [1, 0, 0.3], noise: none}\n"
                                           "faults: [{at_s: 1, device: camera3, do: unplug}]\n",
                                       "s.yaml");
  REQUIRE(scenario);
  REQUIRE(scenario->more_cameras.size() == 2);
  CHECK(scenario->more_cameras[0].xyz == Vec3(0.3, 1.6, 1.5));
  CHECK(scenario->more_cameras[0].noise == "kinect");
  CHECK(scenario->more_cameras[1].noise == "none");
  CHECK(scenario->faults[0].device == "camera3");
}

TEST_CASE("what is wrong with more cameras is said with its place", "[scenario]") {
  using Catch::Matchers::Contains;
  CHECK_THAT(refusal("more_cameras: [{xyz: [1, 0, 1], look_at: [1, 0, 1]}]\n"),
             Contains("s.yaml:4:") && Contains("more_cameras[0].look_at is where the camera is"));
  CHECK_THAT(refusal("more_cameras: [{}, {}, {}, {}]\n"), Contains("s.yaml:4:") && Contains("more_cameras"));
  CHECK_THAT(refusal("more_cameras: [{xzy: [1, 0, 1]}]\n"), Contains("xyz"));
  CHECK_THAT(refusal("faults: [{at_s: 1, device: camera2, do: unplug}]\n"),
             Contains("camera2") && Contains("there are 1 cameras"));
  CHECK_THAT(refusal("more_cameras: [{}]\nfaults: [{at_s: 1, device: camera2, do: puck-reset}]\n"),
             !Contains("accepted"));
  CHECK(refusal("more_cameras: [{}]\nfaults: [{at_s: 1, device: camera2, do: blind}]\n") == "accepted");
}
