#include "control/lift/energy_tank.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <random>

using namespace colift;
using control::EnergyTank;
using hal::Vec3;

namespace {

hal::Pose at(double z_m, double turned_rad = 0.0) {
  hal::Pose X = hal::Pose::Identity();
  X.translation().z() = z_m;
  X.linear() = Eigen::AngleAxisd(turned_rad, Vec3::UnitX()).toRotationMatrix();
  return X;
}

hal::Wrench weight(double n) {
  return {Vec3(0.0, 0.0, -n), Vec3::Zero()};
}

}  // namespace

TEST_CASE("what raises a load comes out of the tank, and the way down gives it back") {
  EnergyTank tank;
  tank.fill(10.0);
  for (int i = 0; i <= 100; ++i) tank.update(at(0.001 * i), weight(40.0));
  CHECK(tank.level_j() == Approx(10.0 - 40.0 * 0.1));
  for (int i = 100; i >= 0; --i) tank.update(at(0.001 * i), weight(40.0));
  CHECK(tank.level_j() == Approx(10.0));
  CHECK(tank.min_level_j() == Approx(6.0));
}

TEST_CASE("a palm that is pushed aside gives nothing, one that drags somebody along does") {
  EnergyTank tank;
  tank.fill(1.0);
  for (int i = 0; i <= 100; ++i) tank.update(at(0.001 * i), {Vec3(0.0, 0.0, 30.0), Vec3::Zero()});
  CHECK(tank.min_level_j() == 1.0);
  for (int i = 100; i <= 140; ++i) tank.update(at(0.001 * i), {Vec3(0.0, 0.0, -30.0), Vec3::Zero()});
  CHECK(tank.level_j() == Approx(1.0 - 1.2));
  CHECK(tank.speed_scale(0.5) == 0.0);
}

TEST_CASE("turning against a torque counts, too") {
  EnergyTank tank;
  tank.fill(1.0);
  for (int i = 0; i <= 100; ++i) tank.update(at(0.0, 0.001 * i), {Vec3::Zero(), Vec3(-5.0, 0.0, 0.0)});
  CHECK(tank.level_j() == Approx(1.0 - 0.5).epsilon(0.001));
}

TEST_CASE("it is never fuller than it was filled, and the palm slows down over its last part") {
  EnergyTank tank;
  CHECK(tank.speed_scale(1.0) == 1.0);  // nothing is counted
  tank.fill(1.0);
  for (int i = 100; i >= 0; --i) tank.update(at(0.001 * i), weight(40.0));
  CHECK(tank.level_j() == 1.0);
  CHECK(tank.speed_scale(0.5) == 1.0);
  CHECK(tank.speed_scale(2.0) == Approx(0.5));
  tank.close();
  CHECK(tank.speed_scale(2.0) == 1.0);
}

TEST_CASE("a gap and a pose that is no number are not the arm's doing") {
  EnergyTank tank;
  tank.fill(1.0);
  tank.update(at(0.0), weight(50.0));
  tank.interrupt();
  tank.update(at(1.0), weight(50.0));
  CHECK(tank.level_j() == 1.0);
  tank.update(at(NAN), weight(50.0));
  tank.update(at(1.0), {Vec3(0.0, NAN, 0.0), Vec3::Zero()});
  CHECK(tank.level_j() == 1.0);
}

TEST_CASE("who keeps to the tank's part of its speed never gives more than was allowed, whatever pulls") {
  constexpr double kAllowed_j = 1.0, kBand_j = 0.5, kStep_m = 1e-3, kTurn_rad = 2e-3;
  for (unsigned seed = 1; seed <= 20; ++seed) {
    CAPTURE(seed);
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> part(-1.0, 1.0);
    const auto any = [&] { return Vec3(part(random), part(random), part(random)); };
    EnergyTank tank;
    tank.fill(kAllowed_j);
    hal::Pose X = at(0.0);
    tank.update(X, {});
    double before_j = kAllowed_j;
    bool was_empty = false;
    for (int i = 0; i < 2'000; ++i) {
      // the way that it wants to go, and a wrench that is against it nine times in ten
      const double pace = tank.speed_scale(kBand_j);
      const Vec3 moved = pace * kStep_m * any(), turned = pace * kTurn_rad * any();
      const double against = part(random) < 0.8 ? -1.0 : 1.0;
      X.translation() += moved;
      if (turned.norm() > 0.0)
        X.linear() = Eigen::AngleAxisd(turned.norm(), turned.normalized()).toRotationMatrix() * X.linear();
      tank.update(X, {against * 5e4 * moved, against * 2e3 * turned});
      REQUIRE(tank.level_j() >= 0.0);
      REQUIRE(tank.level_j() <= kAllowed_j);
      REQUIRE(tank.min_level_j() <= tank.level_j());
      if (pace == 0.0) REQUIRE(tank.level_j() == before_j);  // empty: nothing is given
      before_j = tank.level_j();
      was_empty = was_empty || tank.level_j() < 0.1 * kBand_j;
    }
    CHECK(was_empty);
  }
}
