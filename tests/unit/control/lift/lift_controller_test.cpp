#include "control/lift/lift_controller.hpp"

#include <catch2/catch.hpp>

using namespace colift;
using control::LiftController;

namespace {

/// Torque that is superposed after a second in which this was felt.
double superposed_nm(const hal::Wrench& measured) {
  const hal::RobotModel& model = hal::built_in_robot();
  LiftController lift(model, planner::arm_geometry(model).value(), {});
  hal::JointVector q;
  q << 0.0, 0.35, 0.0, 1.75, 0.0, -0.9, 0.0;
  lift.start(q);
  lift.lift(LiftController::Role::Lead, 0.01, 10.0);
  std::optional<LiftController::Command> command;
  for (int i = 0; i < 500; ++i) command = lift.step(0.002, measured);
  REQUIRE(command);
  return command->tau_superposed_nm.norm();
}

}  // namespace

TEST_CASE("what the hand bears is fed forward, what pushes it up is not") {
  const double bears = superposed_nm({hal::Vec3(0.0, 0.0, -20.0), hal::Vec3::Zero()});
  CHECK(bears > 5.0);
  CHECK(superposed_nm({hal::Vec3(0.0, 0.0, -40.0), hal::Vec3::Zero()}) == Approx(2.0 * bears).epsilon(1e-6));
  // the ground under the object: fed forward, the arm would press it down ever harder
  CHECK(superposed_nm({hal::Vec3(0.0, 0.0, 20.0), hal::Vec3(1.0, 1.0, 0.0)}) == 0.0);
  // sideways the arm stays soft
  CHECK(superposed_nm({hal::Vec3(20.0, -20.0, 0.0), hal::Vec3::Zero()}) == 0.0);
}
