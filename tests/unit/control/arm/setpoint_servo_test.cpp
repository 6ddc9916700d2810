// Set points, torque and stiffness that whoever knows them gives anew in every cycle.
#include <cmath>

#include "setpoint_rig.hpp"

using namespace colift;
using namespace colift::control;
using namespace colift::control::test;

TEST_CASE("a set point that moves is served exactly; one that jumps, within limits and without overshoot",
          "[cycle]") {
  Rig rig;
  JointVector goal = home();
  for (int i = 0; i < 1000; ++i) {
    goal[1] = home()[1] + 0.05 * (1.0 - std::cos(i * 0.003));
    rig.cycle.servo(goal, JointVector::Zero());
    rig.step();
    CHECK((rig.last.q_rad - goal).cwiseAbs().maxCoeff() < 1e-9);
  }
  rig.cycle.servo(goal, JointVector::Zero());
  rig.run();
  const JointVector from = rig.last.q_rad;
  goal[0] += 0.4;
  goal[6] -= 0.01;
  double top = -1e9, bottom = 1e9;
  for (int i = 0; i < 2000; ++i) {
    rig.cycle.servo(goal, JointVector::Zero());
    rig.step();
    top = std::max(top, rig.last.q_rad[0]);
    bottom = std::min(bottom, rig.last.q_rad[6]);
  }
  CHECK((rig.last.q_rad - goal).cwiseAbs().maxCoeff() < 1e-6);
  CHECK(top <= goal[0] + 1e-9);
  CHECK(bottom >= goal[6] - 1e-9);
  CHECK(top > from[0]);
  CHECK(rig.hardest <= rig.limits.acceleration_rad_s2 + 1e-6);
}

TEST_CASE("a set point beyond a joint's end is served up to the margin, one that is not a number never",
          "[cycle]") {
  Rig rig;
  JointVector goal = home();
  goal[3] = -9.0;
  rig.cycle.servo(goal, JointVector::Zero());
  rig.steps(5000);
  CHECK(rig.last.q_rad[3] == Approx(robot().lower_rad()[3] + rig.limits.limit_margin_rad).margin(1e-6));
  CHECK(rig.last.q_rad[3] >= robot().lower_rad()[3] + rig.limits.limit_margin_rad - 1e-12);
  goal[3] = kNan;
  rig.cycle.servo(goal, JointVector::Zero());
  rig.cycle.servo(home(), JointVector::Constant(kNan));
  rig.cycle.superpose(JointVector::Constant(kNan));
  rig.cycle.set_stiffness(kNan);
  rig.steps(10);
  CHECK(rig.last.stiffness_nm_rad.allFinite());
}

TEST_CASE("hold ends the service of a set point at rest, and keeps the torque that bears the load",
          "[cycle]") {
  Rig rig;
  JointVector goal = home(), tau = JointVector::Zero();
  tau[1] = 12.0;
  for (int i = 0; i < 500; ++i) {
    goal[0] += 0.5 * rig.period_s;
    rig.cycle.servo(goal, tau);
    rig.step();
  }
  rig.cycle.hold();
  CHECK(rig.run() < 0.2);
  rig.steps(100);
  CHECK(rig.last.tau_superposed_nm == tau);
  CHECK(rig.hardest <= rig.limits.acceleration_rad_s2 + 1e-6);
}

TEST_CASE("torque and stiffness change with their slopes", "[cycle]") {
  Rig rig;
  JointVector tau = JointVector::Zero();
  tau[1] = 20.0;
  rig.cycle.superpose(tau);
  rig.cycle.set_stiffness(200.0);
  ImpedanceCommand before = rig.last;
  for (int i = 0; i < 1000; ++i) {
    rig.step();
    CHECK(std::abs(rig.last.tau_superposed_nm[1] - before.tau_superposed_nm[1]) <=
          rig.limits.torque_slope_nm_s * rig.period_s + 1e-12);
    CHECK(std::abs(rig.last.stiffness_nm_rad[0] - before.stiffness_nm_rad[0]) <=
          rig.limits.stiffness_slope_nm_rad_s * rig.period_s + 1e-9);
    before = rig.last;
  }
  CHECK(rig.last.tau_superposed_nm == tau);
  CHECK(rig.last.stiffness_nm_rad == JointVector::Constant(200.0));
}
