#include "control/lift/energy_tank.hpp"

#include <catch2/catch.hpp>
#include <cmath>

using namespace colift;
using control::EnergyTank;
using hal::JointVector;

namespace {

/// One joint that is a spring to its set point, and a torque that is added.
struct Joint {
  EnergyTank tank;
  double q = 0.0, set = 0.0, stiffness = 1500.0, added = 0.0;

  void cycle() {
    const double spring = stiffness * (set - q);
    tank.update(q * JointVector::UnitX(), (spring + added) * JointVector::UnitX(), 0.5 * spring * (set - q));
  }
};

}  // namespace

TEST_CASE("springs alone give nothing that was not put in") {
  Joint joint;
  joint.tank.fill(1.0);
  for (int i = 0; i <= 400; ++i) {  // somebody pushes it aside, far and back, again and again
    joint.q = 0.05 * std::sin(0.1 * i);
    joint.cycle();
  }
  CHECK(joint.tank.min_level_j() == Approx(1.0).margin(1e-9));
}

TEST_CASE("what raises a load comes out of the tank, and the way down gives it back") {
  Joint joint;
  joint.tank.fill(10.0);
  joint.added = 40.0;  // N m, as the load that it bears
  for (int i = 0; i <= 100; ++i, joint.q = joint.set = 0.001 * i) joint.cycle();
  CHECK(joint.tank.level_j() == Approx(10.0 - 40.0 * 0.1).epsilon(0.02));
  for (int i = 100; i >= 0; --i, joint.q = joint.set = 0.001 * i) joint.cycle();
  CHECK(joint.tank.level_j() == Approx(10.0).epsilon(0.02));
  CHECK(joint.tank.min_level_j() == Approx(6.0).epsilon(0.02));
}

TEST_CASE(
    "a set point that is dragged away from somebody who holds on empties it, by what the spring takes") {
  Joint joint;
  joint.tank.fill(1.0);
  for (int i = 0; i <= 40; ++i, joint.set = 0.001 * i) joint.cycle();
  CHECK(joint.tank.level_j() == Approx(1.0 - 0.5 * 1500.0 * 0.04 * 0.04).margin(0.05));
  CHECK(joint.tank.speed_scale(0.5) == 0.0);
}

TEST_CASE("springs that are made stiffer while they are stretched take from it, too") {
  Joint joint;
  joint.tank.fill(5.0);
  joint.set = 0.05;
  joint.stiffness = 150.0;
  joint.cycle();
  joint.stiffness = 1500.0;
  joint.cycle();
  CHECK(joint.tank.level_j() == Approx(5.0 - 0.5 * 1350.0 * 0.05 * 0.05));
}

TEST_CASE("it is never fuller than it was filled, and the palm slows down over its last part") {
  Joint joint;
  joint.tank.fill(1.0);
  joint.added = -30.0;
  for (int i = 0; i <= 100; ++i, joint.q = joint.set = 0.001 * i) joint.cycle();
  CHECK(joint.tank.level_j() == 1.0);
  CHECK(joint.tank.speed_scale(0.5) == 1.0);
  CHECK(joint.tank.speed_scale(2.0) == Approx(0.5));
  joint.tank.close();
  CHECK(joint.tank.speed_scale(2.0) == 1.0);
}

TEST_CASE("a gap and a position that is no number are not the arm's doing") {
  Joint joint;
  joint.tank.fill(1.0);
  joint.added = 50.0;
  joint.cycle();
  joint.tank.interrupt();
  joint.q = joint.set = 1.0;
  joint.cycle();
  CHECK(joint.tank.level_j() == 1.0);
  joint.q = NAN;
  joint.cycle();
  CHECK(joint.tank.level_j() == 1.0);
}
