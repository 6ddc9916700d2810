// A camera that was pushed by more than a calibration is off: refused with every scene, until it stands
// right.

#include <catch2/catch.hpp>

#include "control/session/perception_session.hpp"
#include "sim_hal/synthetic/kinect/kinect_noise.hpp"
#include "tests/unit/perception/self_filter/robot_view.hpp"

using namespace colift;
using hal::Vec3;
using sim_hal::Label;
using Verdict = perception::CameraCorrection::Verdict;

namespace {

/// A robot at rest before a box, seen by one camera.
struct Rig {
  hal::RobotModel model = hal::built_in_robot();
  planner::HandModel hand;
  control::Config config = control::run_defaults();
  control::RobotPosture robot;
  hal::Pose X_WC = sim_hal::look_at(Vec3(2.0, -1.1, 1.5), Vec3(0.9, 0.0, 0.3));
  hal::SteadyClock clock;

  Rig() { robot.q_rad << 0.0, 0.35, 0.0, 1.75, 0.0, -0.9, 0.0; }

  [[nodiscard]] std::vector<hal::DepthFrame> frames(const hal::Pose& X_WC_true) const {
    sim_hal::World world;
    world.shapes.push_back(sim_hal::half_space(Vec3::Zero(), Vec3::UnitZ(), Label::Ground));
    world.shapes.push_back(sim_hal::box(Vec3(1.15, 0.1, 0.22), {0.8, 0.6, 0.44}, 0.2, Label::Target));
    perception::test::add_robot(world, model, robot.q_rad, robot.hand);
    const auto truth = sim_hal::cast_rays(world, hal::CameraIntrinsics{}, X_WC_true);
    std::vector<hal::DepthFrame> out;
    for (std::uint64_t i = 0; i < 8; ++i) out.push_back(sim_hal::measure(truth, {}, i));
    return out;
  }

  hal::Result<> look(control::PerceptionSession& session, const hal::Pose& X_WC_true) const {
    for (hal::DepthFrame& frame : frames(X_WC_true)) session.add_reference(std::move(frame), robot);
    return session.analyse_scene(robot);
  }
};

}  // namespace

TEST_CASE("a camera that was pushed too far is refused with every scene, not with the first alone",
          "[arm_in_view]") {
  const Rig rig;
  hal::Pose pushed = rig.X_WC;
  pushed.translate(Vec3(0.08, 0.0, 0.0));
  control::PerceptionSession session(control::Method::Fast, rig.config,
                                     {rig.model, rig.hand, nullptr, rig.X_WC}, rig.clock);
  for (int scene = 0; scene < 3; ++scene) {
    INFO("scene " << scene);
    const auto seen = rig.look(session, pushed);
    REQUIRE_FALSE(seen);
    CHECK(seen.error().where == control::kCameraOff);
    CHECK(seen.error().detail.find("calibrate again") != std::string::npos);
    REQUIRE(session.camera_correction());
    CHECK(session.camera_correction()->verdict == Verdict::Refused);
  }
  // somebody puts it back
  const auto seen = rig.look(session, rig.X_WC);
  if (!seen) FAIL(seen.error().text());
  CHECK(session.camera_correction()->verdict != Verdict::Refused);
  CHECK(session.analysis().scene.target);
}
