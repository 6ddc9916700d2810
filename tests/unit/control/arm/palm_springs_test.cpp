// Which impedance the arm carries with: the palm's where the link is quick enough and the arm takes torques.
#include <catch2/catch.hpp>

#include "control/arm/arm_controller.hpp"

using namespace colift;
using control::ArmController;
using control::ArmRequest;

namespace {

/// Cycles of an arm that stands where it is commanded, then the begin of a lift and two seconds of it.
struct Carrying {
  control::ArmView view;
  hal::ImpedanceCommand command;
};

Carrying carry(double period_s, const hal::ArmAbilities& can = {},
               const std::string& control = "cartesian_impedance") {
  control::TaskConfig task;
  task.lift.control = control;
  const hal::RobotModel& model = hal::built_in_robot();
  ArmController arm(model, planner::arm_geometry(model).value(), task, {}, {}, {.on = false}, can);
  hal::ArmState state;
  state.q_rad << 0.0, 0.35, 0.0, 1.75, 0.0, -0.9, 0.0;
  state.may_command = true;
  Carrying result;
  const auto cycle = [&] {
    state.measured_at += hal::duration_of(period_s);
    arm.measured(state);
    const auto command = arm.command();
    if (!command) return;
    result.command = *command;
    state.q_rad = state.q_commanded_rad = command->q_rad;
  };
  for (int i = 0; i < 50; ++i) cycle();
  ArmRequest lift{ArmRequest::Kind::StartLift, 1};
  lift.number = 0.02;
  lift.time_s = 2.0;
  arm.take(lift);
  for (double t = 0.0; t < 2.0; t += period_s) cycle();
  result.view = arm.view();
  return result;
}

bool equal_joints(const hal::ImpedanceCommand& c) {
  return (c.stiffness_nm_rad.array() == c.stiffness_nm_rad[0]).all();
}

}  // namespace

TEST_CASE("the palm is the spring where the link is quick, the joints where it is slow") {
  for (const double period_s : {0.001, 0.002, 0.005}) {
    const Carrying quick = carry(period_s);
    CHECK(quick.view.palm_springs);
    CHECK_FALSE(equal_joints(quick.command));
  }
  for (const double period_s : {0.010, 0.050}) {
    const Carrying slow = carry(period_s);
    CHECK_FALSE(slow.view.palm_springs);
    CHECK(equal_joints(slow.command));
  }
}

TEST_CASE("an arm that takes no torques, and a task that says so, keep the impedance of the joints") {
  hal::ArmAbilities can;
  can.superposed_torque = false;
  CHECK_FALSE(carry(0.005, can).view.palm_springs);
  const Carrying joints = carry(0.005, {}, "joint_impedance");
  CHECK_FALSE(joints.view.palm_springs);
  CHECK(equal_joints(joints.command));
  // the energy is counted under either
  CHECK(joints.view.energy_j > 0.0);
}
