// An arm that a person pushes: how hard it presses, whether it springs back.
#include "control/arm/yield_law.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>

using namespace colift;
using namespace colift::control;
using hal::JointVector;

namespace {

constexpr double kPeriod_s = 0.005;

/// Joint A2 as a mass on the spring of the arm's controller, with somebody at it.
struct Joint {
  ForceMonitorConfig config;
  YieldLaw law{config};
  double inertia = 2.0, damping = 0.0;
  JointVector q = JointVector::Zero(), commanded = JointVector::Zero();
  double speed = 0.0, stiffness = config.yield_stiffness_nm_rad;

  [[nodiscard]] double spring_nm() const { return stiffness * (commanded[1] - q[1]); }
  void cycle(double push_nm, bool pressed) {
    for (int i = 0; i < 5; ++i) {
      speed += 0.001 * (push_nm + spring_nm() - damping * speed) / inertia;
      q[1] += 0.001 * speed;
    }
    commanded = law.step(q, commanded, JointVector::Constant(stiffness), pressed, kPeriod_s);
  }
};

}  // namespace

TEST_CASE("a joint that is pushed takes its set point along and presses no harder") {
  Joint joint;
  const double most_nm = joint.config.yield_band_rad * joint.config.yield_stiffness_nm_rad;
  for (int i = 0; i < 200; ++i) {
    joint.q[1] += 0.01;
    joint.commanded =
        joint.law.step(joint.q, joint.commanded, JointVector::Constant(joint.stiffness), true, kPeriod_s);
    CHECK(std::abs(joint.spring_nm()) <= Approx(most_nm));
  }
  CHECK(joint.commanded[1] >= Approx(joint.q[1] - joint.config.yield_band_rad));
  CHECK(joint.commanded[0] == 0.0);
}

TEST_CASE("a joint that is still stiff presses with no more torque than a soft one") {
  Joint joint;
  joint.stiffness = 1500.0;
  joint.q[1] = 0.3;
  joint.commanded =
      joint.law.step(joint.q, joint.commanded, JointVector::Constant(joint.stiffness), true, kPeriod_s);
  CHECK(-joint.spring_nm() <= Approx(0.1 * 150.0));
}

TEST_CASE("a joint that was kicked does not give the kick back") {
  // the energy that comes back against what was put in; without the law all of it
  Joint joint;
  joint.speed = 3.0;
  const double kick_j = 0.5 * joint.inertia * joint.speed * joint.speed;
  double fastest_back = 0.0;
  for (int i = 0; i < 600; ++i) {
    joint.cycle(0.0, false);
    fastest_back = std::max(fastest_back, -joint.speed);
  }
  CHECK(0.5 * joint.inertia * fastest_back * fastest_back < 0.1 * kick_j);
}

TEST_CASE("who stays pressed is pressed lightly soon") {
  Joint joint;
  joint.damping = 40.0;
  joint.q[1] = 0.1;  // held there: 15 N m
  const bool pressed = GENERATE(true, false);
  for (int i = 0; i < 200; ++i)
    joint.commanded =
        joint.law.step(joint.q, joint.commanded, JointVector::Constant(joint.stiffness), pressed, kPeriod_s);
  // a load that no limit is broken by does not make the arm creep away
  const double expected = pressed ? joint.config.yield_relaxed_band_rad * joint.stiffness : 15.0;
  CHECK(-joint.spring_nm() == Approx(expected).epsilon(0.1));
}

TEST_CASE("a load that is compensated wrongly does not make the arm sink") {
  // 17 N m too much at A2: with a band that follows whatever moves, it drifted at 0.04 rad/s without an end
  Joint joint;
  joint.damping = 25.0;
  for (int i = 0; i < 2000; ++i) joint.cycle(17.0, false);
  CHECK(joint.q[1] == Approx(17.0 / joint.stiffness).margin(0.02));
}

TEST_CASE("an arm that has lost its load is not let fly") {
  // 36 N m too much at A2, as of 40 N that are knocked out of the hand: followed as if it swung, it went up
  // by 0.56 rad/s for as long as the arm yielded
  Joint joint;
  joint.damping = 65.0;
  for (int i = 0; i < 10; ++i) joint.cycle(60.0, true);
  for (int i = 0; i < 2000; ++i) joint.cycle(36.0, false);
  CHECK(std::abs(joint.speed) < 0.01);
  CHECK(joint.q[1] < 0.3 + 36.0 / joint.stiffness);
}

TEST_CASE("what stiff springs held is known before they become soft") {
  Joint joint;
  joint.commanded[1] = 0.004;  // 6 N m of a load at 1500 N m/rad
  for (int i = 0; i < 400; ++i) joint.law.rest(1500.0 * (joint.commanded - joint.q), kPeriod_s);
  CHECK(joint.law.held_nm()[1] == Approx(6.0).epsilon(0.01));
  CHECK(joint.law.held_nm()[2] == 0.0);
  SECTION("a figure that is not a number teaches nothing") {
    JointVector lost = joint.q;
    lost[3] = NAN;
    joint.law.rest(1500.0 * (joint.commanded - lost), kPeriod_s);
    CHECK(joint.law.held_nm().allFinite());
  }
  SECTION("more than a load's error is somebody's push") {
    joint.commanded[1] = 0.1;
    for (int i = 0; i < 400; ++i) joint.law.rest(1500.0 * (joint.commanded - joint.q), kPeriod_s);
    CHECK(joint.law.held_nm()[1] == 10.0);
  }
}
