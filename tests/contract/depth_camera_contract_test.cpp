#include <catch2/catch.hpp>
#include <memory>

#include "colift/contract/camera_contract.hpp"
#include "hal/drivers/recorded/recorded_camera.hpp"
#include "sim_hal/mock/mock_camera.hpp"
#include "sim_hal/mujoco/devices/sim_devices.hpp"
#include "tests/support/video_rig.hpp"
#ifdef COLIFT_KINECT
#include "tests/support/camera_rig.hpp"
#endif
#ifdef COLIFT_OPENNI2
#include "tests/support/openni2_rig.hpp"
#endif

namespace colift {
namespace {

// A back end that is ready to be configured, and what it needs to live.
struct RecordedRig {
  hal::RecordedCamera camera{
      hal::RecordedCameraConfig{std::string(COLIFT_TEST_DATA) + "/real/02_laptop_and_box", 0.25, true}};
};

struct MockRig {
  hal::ManualClock clock;
  sim_hal::MockCamera camera{script(), clock};

  static sim_hal::CameraScript script() {
    sim_hal::CameraScript s;
    s.world = [](std::uint64_t) {
      sim_hal::World world;
      world.shapes.push_back(
          sim_hal::half_space(hal::Vec3::Zero(), hal::Vec3::UnitZ(), sim_hal::Label::Ground));
      return world;
    };
    s.X_WC = sim_hal::look_at({-1.0, 0, 1.0}, {0, 0, 0});
    return s;
  }
};

struct SimRig {
  std::unique_ptr<sim_hal::SimWorld> world =
      sim_hal::SimWorld::make(sim_hal::built_in_scenario(), hal::built_in_robot(), 1, sim_hal::SimConfig{})
          .value();
  std::unique_ptr<hal::DepthCamera> owned = sim_hal::make_sim_camera(*world);
  hal::DepthCamera& camera = *owned;
};

// in real time, over the emulated device's system calls
using tests::VideoRig;

// in real time, through the capture process
#ifdef COLIFT_KINECT
using tests::CameraRig;
#define COLIFT_KINECTS , CameraRig
#else
#define COLIFT_KINECTS
#endif
// the same, and OpenNI2's own library in it
#ifdef COLIFT_OPENNI2
using tests::Openni2Rig;
#define COLIFT_OPENNI2_CAMERAS , Openni2Rig
#else
#define COLIFT_OPENNI2_CAMERAS
#endif
#define COLIFT_CAMERAS RecordedRig, MockRig, SimRig, VideoRig COLIFT_KINECTS COLIFT_OPENNI2_CAMERAS

}  // namespace

TEMPLATE_TEST_CASE("a depth camera keeps its contract", "[camera][contract]", COLIFT_CAMERAS) {
  contract::check_camera([] {
    auto rig = std::make_shared<TestType>();
    return contract::CameraUnderTest{rig, &rig->camera};
  });
}

}  // namespace colift
