// A lift of a few millimetres tells where the centre of gravity is, as far as torques can.

#include <catch2/catch.hpp>
#include <cmath>

#include "control/test_lift.hpp"

using namespace colift;
using control::TestLift;
using hal::Vec3;

namespace {

constexpr double kGravity = 9.80665;

// a rigid object in balance: the partner bears the moment as a force at his point
control::TestLiftInput felt_by_robot(double mass, const Vec3& cog, const Vec3& partner, const Vec3& palm) {
  control::TestLiftInput in;
  in.partner = partner;
  in.palm = in.grasp = palm;
  in.cog = {0.9, 0.0, 0.3};
  in.cog_covariance = 1e-4 * Eigen::Matrix3d::Identity();
  const Vec3 weight(0.0, 0.0, mass * kGravity);
  // the lever rule along the line between the hands; the rest is a torque of the robot's hand
  const Vec3 span = palm - partner;
  const double part = (cog - partner).head<2>().dot(span.head<2>()) / span.head<2>().squaredNorm();
  const Vec3 on_object = part * weight;
  const Vec3 torque = (cog - partner).cross(weight) - span.cross(on_object);
  in.felt = {-on_object, -torque};
  in.share_predicted = 0.5;
  return in;
}

}  // namespace

TEST_CASE("an even object is lifted on", "[test_lift]") {
  const auto t =
      understand_test_lift(felt_by_robot(4.0, {0.9, 0.0, 0.3}, {1.3, 0.0, 0.4}, {0.5, 0.0, 0.4}), {});
  REQUIRE(t);
  CHECK(t->next == TestLift::Next::GoOn);
  CHECK(t->mass_kg == Approx(4.0).epsilon(1e-6));
  CHECK(t->share == Approx(0.5).epsilon(1e-6));
  CHECK(t->lever_m < 1e-6);
}

TEST_CASE("a centre of gravity beside the line is found, and grasped again", "[test_lift]") {
  const Vec3 cog(0.9, 0.15, 0.3);
  const auto t = understand_test_lift(felt_by_robot(4.0, cog, {1.3, 0.0, 0.4}, {0.5, 0.0, 0.4}), {});
  REQUIRE(t);
  CHECK(t->next == TestLift::Next::Regrasp);
  // the direction from the partner is exact
  const Eigen::Vector2d a = (t->cog - Vec3(1.3, 0, 0)).head<2>().normalized(),
                        b = (cog - Vec3(1.3, 0, 0)).head<2>().normalized();
  CHECK((a - b).norm() < 1e-6);
  CHECK(t->lever_m > 0.1);
  SECTION("with the mass known, all of it is") {
    auto in = felt_by_robot(4.0, cog, {1.3, 0.0, 0.4}, {0.5, 0.0, 0.4});
    in.known_mass_kg = 4.0;
    const auto known = understand_test_lift(in, {});
    REQUIRE(known);
    CHECK((known->cog - cog).norm() < 1e-6);
  }
}

TEST_CASE("mass and distance along the line are one number only, unless one is known", "[test_lift]") {
  // 4 kg at 0.25 m from the partner feel like 2.5 kg at the believed 0.4 m
  auto in = felt_by_robot(4.0, {1.05, 0.0, 0.3}, {1.3, 0.0, 0.4}, {0.5, 0.0, 0.4});
  const auto t = understand_test_lift(in, {});
  REQUIRE(t);
  CHECK(t->mass_kg == Approx(2.5).epsilon(1e-3));
  in.known_mass_kg = 4.0;
  const auto known = understand_test_lift(in, {});
  REQUIRE(known);
  CHECK(known->cog.x() == Approx(1.05).epsilon(1e-6));
  CHECK(known->next == TestLift::Next::OtherShare);
  CHECK(known->share == Approx(0.3125).epsilon(1e-6));
}

TEST_CASE("an object that stands on the ground says nothing", "[test_lift]") {
  auto in = felt_by_robot(0.1, {0.9, 0.0, 0.3}, {1.3, 0.0, 0.4}, {0.5, 0.0, 0.4});
  const auto t = understand_test_lift(in, {});
  REQUIRE_FALSE(t);
  CHECK(t.error().code == hal::ErrorCode::NotFound);
  in.felt.force.x() = NAN;
  CHECK(understand_test_lift(in, {}).error().code == hal::ErrorCode::BadInput);
  in = felt_by_robot(4.0, {0.9, 0.0, 0.3}, {1.3, 0.0, 0.4}, {1.28, 0.0, 0.4});
  CHECK(understand_test_lift(in, {}).error().code == hal::ErrorCode::BadInput);
}
