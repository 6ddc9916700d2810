// The watch on the way: a push, an arm that does not follow.
#include <cmath>

#include "setpoint_rig.hpp"

using namespace colift;
using namespace colift::control;
using namespace colift::control::test;

TEST_CASE("a push on the way is told within 10 ms, a lesser one or an old one is not", "[cycle]") {
  Rig rig;
  const auto torque = [&](double n) {
    const hal::ArmJacobian J = hal::jacobian(robot(), rig.state.q_rad, hal::Vec3::Zero());
    Eigen::Matrix<double, 6, 1> F;
    F << 0.6 * n, -0.8 * n, 0, 0, 0, 0;
    return JointVector(J.transpose() * F);
  };
  // what is felt at rest is the watch's zero
  const JointVector offset = torque(25.0);
  rig.state.tau_external_nm = offset;
  rig.steps(1000);
  REQUIRE(rig.cycle.follow(way({home(), there()})));
  rig.steps(400);
  CHECK_FALSE(rig.cycle.blocked());
  for (int i = 0; i < 200; ++i) {
    rig.state.tau_external_nm = offset + torque(20.0);
    rig.step();
  }
  CHECK_FALSE(rig.cycle.blocked());
  int cycles = 0;
  for (; !rig.cycle.blocked() && cycles < 100; ++cycles) {
    rig.state.tau_external_nm = offset + torque(60.0);
    rig.step();
  }
  CHECK(cycles <= 10);
  CHECK_THAT(control::describe(rig.cycle.blockage()), Catch::Matchers::Contains("limit 30 N"));

  // back out of it: the contact that is still there does not count, a new one does
  rig.cycle.hold();
  while (!rig.cycle.done()) rig.step();
  rig.cycle.back();
  rig.steps(20);
  CHECK_FALSE(rig.cycle.blocked());
  rig.state.tau_external_nm = offset;
  rig.steps(50);
  rig.state.tau_external_nm = offset + torque(60.0);
  rig.steps(20);
  CHECK(rig.cycle.blocked());
}

TEST_CASE("an arm that does not follow its command is told", "[cycle]") {
  Rig rig;
  REQUIRE(rig.cycle.follow(way({home(), there()})));
  rig.steps(200);
  const JointVector stuck = rig.state.q_rad;
  double lag = 0.0;
  for (int i = 0; i < 2000 && !rig.cycle.blocked(); ++i) {
    rig.step();
    lag = (rig.last.q_rad - stuck).cwiseAbs().maxCoeff();
    rig.state.q_rad = stuck;
  }
  CHECK(rig.cycle.blocked());
  CHECK(lag < rig.limits.follow_error_rad + 0.002);
  CHECK_THAT(control::describe(rig.cycle.blockage()), Catch::Matchers::Contains("A7 does not follow"));
}

TEST_CASE("a contact that a motion begins in, and leaves, is no force of the motions after it", "[cycle]") {
  Rig rig;
  const auto touch = [&](double n) {  // straight up, as an object bears a hand that leans on it
    const hal::ArmJacobian J = hal::jacobian(robot(), rig.state.q_rad, hal::Vec3::Zero());
    Eigen::Matrix<double, 6, 1> F;
    F << 0, 0, n, 0, 0, 0;
    return JointVector(J.transpose() * F);
  };
  rig.steps(1000);
  const auto follow = [&](const JointVector& from, const JointVector& to, bool ends) {
    REQUIRE(rig.cycle.follow(way({from, to})));
    while (ends && !rig.cycle.done()) rig.step();
  };
  follow(home(), there(), true);
  rig.state.tau_external_nm = touch(40.0);
  rig.steps(1000);
  follow(there(), beyond(), false);
  rig.steps(20);
  rig.state.tau_external_nm.setZero();
  while (!rig.cycle.done()) rig.step();
  CHECK_FALSE(rig.cycle.blocked());
  rig.steps(2);  // the next one begins at once
  follow(beyond(), home(), false);
  rig.steps(200);
  CHECK_FALSE(rig.cycle.blocked());
  CHECK(rig.cycle.contact_force_n() < 1.0);
  // a push is felt as ever
  int cycles = 0;
  for (; !rig.cycle.blocked() && cycles < 100; ++cycles) {
    rig.state.tau_external_nm = touch(60.0);
    rig.step();
  }
  CHECK(cycles <= 12);
}
