#include <catch2/catch.hpp>

#include "colift/contract/camera_contract.hpp"
#include "tests/dds/camera_rig.hpp"

namespace colift::tests {

TEST_CASE("a camera over ROS 2 keeps the contract of a depth camera", "[dds][camera][contract]") {
  contract::CameraTraits traits;
  traits.frame_timeout = std::chrono::milliseconds(10'000);
  contract::check_camera(
      [] {
        auto rig = std::make_shared<Ros2CameraRig>();
        return contract::CameraUnderTest{rig, &rig->camera};
      },
      traits);
}

}  // namespace colift::tests
