#include "control/lift/lift_controller.hpp"

#include <catch2/catch.hpp>

using namespace colift;
using control::LiftController;

namespace {

hal::JointVector posture() {
  hal::JointVector q;
  q << 0.0, 0.35, 0.0, 1.75, 0.0, -0.9, 0.0;
  return q;
}

/// Torque that is superposed after a second in which this was felt.
double superposed_nm(const hal::Wrench& measured) {
  const hal::RobotModel& model = hal::built_in_robot();
  LiftController lift(model, planner::arm_geometry(model).value(), {});
  lift.start(posture());
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

TEST_CASE("a palm is left where it was taken to, but what a load pulled down comes up again") {
  const hal::RobotModel& model = hal::built_in_robot();
  const planner::ArmGeometry arm = planner::arm_geometry(model).value();
  const LiftController lift(model, arm, {});
  const hal::Pose commanded = planner::flange_pose(arm, posture());
  const auto left_where = [&](const hal::Vec3& taken_by, double turned_by) {
    hal::Pose measured = commanded;
    measured.translation() += taken_by;
    measured.linear() = commanded.linear() * Eigen::AngleAxisd(turned_by, hal::Vec3::UnitX());
    const auto q = planner::follow_ik(arm, measured, posture(), 0.02, 0.5);
    REQUIRE(q);
    return planner::flange_pose(arm, lift.where_taken(posture(), *q));
  };
  const hal::Pose aside = left_where({0.01, -0.02, 0.008}, 0.03);
  CHECK((aside.translation() - commanded.translation()).isApprox(hal::Vec3(0.01, -0.02, 0.008), 1e-3));
  CHECK(Eigen::AngleAxisd(commanded.linear().transpose() * aside.linear()).angle() ==
        Approx(0.03).epsilon(1e-3));
  const hal::Pose pulled_down = left_where({0.01, 0.0, -0.02}, 0.0);
  CHECK((pulled_down.translation() - commanded.translation()).isApprox(hal::Vec3(0.01, 0.0, 0.0), 1e-3));
  // farther than a hand's breadth no spring takes it
  CHECK(left_where({0.0, 0.15, 0.0}, 0.0).isApprox(commanded));
}

TEST_CASE("a palm that is slowed to a stand for somebody does not give way to a moment either", "[lift]") {
  const hal::RobotModel& model = hal::built_in_robot();
  LiftController lift(model, planner::arm_geometry(model).value(), {});
  const hal::Wrench moment{hal::Vec3::Zero(), {0.0, 3.0, 0.0}};
  const auto turned_after_1_s = [&](double pace) {
    lift.start(posture(), {{0.0, 0.0, 0.06}, hal::Vec3::UnitX()});
    lift.lift(LiftController::Role::Lead, 0.05, 2.0);
    hal::JointVector q_rad = posture();
    for (int i = 0; i < 200; ++i) q_rad = lift.step(0.005, moment, pace)->q_rad;
    const Eigen::Matrix3d turn =
        hal::hand_pose(model, q_rad).linear() * hal::hand_pose(model, posture()).linear().transpose();
    return Eigen::AngleAxisd(turn).angle();
  };
  CHECK(turned_after_1_s(0.0) < 1e-6);
  CHECK(turned_after_1_s(1.0) > 0.01);
}
