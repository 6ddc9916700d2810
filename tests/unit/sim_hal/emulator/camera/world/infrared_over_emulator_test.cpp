// Calibration's images on the way that a robot's would come: a world with the emitter on its palm, the
// emulated Kinect before it, the capture process, the driver, and the guard beside them.

#include <catch2/catch.hpp>
#include <cmath>
#include <string>
#include <vector>

#include "hal/drivers/kinect/guarded_kinect.hpp"
#include "perception/calibration/spot_finder.hpp"
#include "sim_hal/emulator/camera/camera_server.hpp"
#include "sim_hal/emulator/mujoco/camera_world_source.hpp"
#include "sim_hal/mujoco/devices/sim_devices.hpp"

using namespace colift;
using namespace std::chrono_literals;

namespace {

/// An arm at rest whose palm looks at the camera, 1.3 m away.
struct Room {
  sim_hal::Scenario scenario =
      sim_hal::parse_scenario(
          "schema: colift.scenario/1\n"
          "object: {kind: box, size: [0.3, 0.3, 0.3], mass: 2.0, pose: {xyz: [-1.6, 1.6, 0.0]}}\n"
          "partner: {kind: none}\n",
          "room")
          .value();
  sim_hal::SimEmitter emitter{.arm_m = 0.0, .spot_px = 0.0};
  std::unique_ptr<sim_hal::SimWorld> world;

  Room() {
    world = sim_hal::SimWorld::make(scenario, hal::built_in_robot(), 1, {}).value();
    const hal::Pose X_WH = hal::hand_pose(hal::built_in_robot(), world->arm_state().q_rad);
    scenario.camera.look_at = X_WH * emitter.at_H;
    scenario.camera.xyz = scenario.camera.look_at + 1.3 * X_WH.linear().col(2);
    scenario.camera.xyz.z() = std::max(0.3, scenario.camera.xyz.z());
    world = sim_hal::SimWorld::make(scenario, hal::built_in_robot(), 1, {}).value();
  }
  /// Where the emitter truly is in the infrared image.
  [[nodiscard]] Eigen::Vector2d truth(const hal::CameraIntrinsics& k) const {
    const hal::Pose X_WH = hal::hand_pose(hal::built_in_robot(), world->truth().q_rad);
    const hal::Vec3 p = camera_pose(scenario.camera).inverse() * (X_WH * emitter.at_H);
    return {k.fx * p.x() / p.z() + k.cx, k.fy * p.y() / p.z() + k.cy};
  }
};

}  // namespace

TEST_CASE("a Kinect behind its guard shows the emitter on the palm where it is, and the depth beside it",
          "[camera][emulated][calibration]") {
  Room room;
  const hal::SteadyClock clock;
  sim_hal::CameraServer server({},
                               std::make_unique<sim_hal::CameraWorldSource>(*room.world, 0, room.emitter));
  REQUIRE(server.start());
  hal::KinectConfig config;
  config.source = "emulated:" + server.address();
  config.infrared_brightness = 7;
  config.open_s = 20.0;
  const hal::GuardedKinect kinect = hal::make_guarded_kinect(config, {}, clock);
  CHECK(kinect.infrared->want_infrared(true).error().code == hal::ErrorCode::NotReady);
  REQUIRE(kinect.camera->configure());
  REQUIRE(kinect.camera->activate());
  REQUIRE(kinect.infrared->want_infrared(true));

  std::vector<hal::InfraredFrame> images;
  for (int i = 0; i < 16; ++i) {
    room.world->advance(33ms);  // the emitter blinks in the world's time: a slow machine sees the same
    auto image = kinect.infrared->next_infrared(10s);
    INFO((image ? "" : image.error().text()));
    REQUIRE(image);
    images.push_back(std::move(*image));
  }
  const auto spot = perception::find_blinking_spot(images, {});
  if (!spot) FAIL(spot.error().reason);
  const Eigen::Vector2d truth = room.truth(images.front().intrinsics);
  INFO(spot->pixel.transpose() << " for " << truth.transpose());
  CHECK((spot->pixel - truth).norm() < 0.3);
  CHECK(server.report().infrared >= 16);
  CHECK(server.report().brightness == 7);

  const auto depth = kinect.camera->next_frame(10s);
  REQUIRE(depth);
  const auto away = perception::depth_near(*depth, spot->pixel);
  REQUIRE(away);
  CHECK(*away == Approx((room.scenario.camera.xyz - room.scenario.camera.look_at).norm()).margin(0.05));
}
