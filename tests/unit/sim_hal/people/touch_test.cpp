#include <catch2/catch.hpp>
#include <cmath>

#include "sim_hal/people/body_region.hpp"
#include "sim_hal/people/soft_body.hpp"
#include "sim_hal/people/touch.hpp"
#include "sim_hal/synthetic/hash_random.hpp"

using namespace colift::sim_hal;

namespace {

/// Smallest distance over many points of the axis.
double by_sampling(const Shape& capsule, const Shape& solid) {
  double smallest = INFINITY;
  for (int i = 0; i <= 2000; ++i) {
    const double s = (i / 2000.0 - 0.5) * capsule.size[1];
    const Vec3 p = capsule.X_WS.translation() + s * capsule.X_WS.linear().col(2);
    smallest = std::min(smallest, distance(solid, p) - capsule.size[0]);
  }
  return smallest;
}

}  // namespace

TEST_CASE("the nearest place of a capsule on a solid is that of a search by sampling") {
  Draws draws(3, 1);
  const auto point = [&] {
    return Vec3(draws.between(-0.5, 0.5), draws.between(-0.5, 0.5), draws.between(-0.5, 0.5));
  };
  const Shape solids[] = {box(Vec3::Zero(), {0.3, 0.2, 0.1}, 0.4, Label::Robot),
                          cylinder(Vec3::Zero(), {0.3, 0.2, 1.0}, 0.08, 0.4, Label::Robot),
                          sphere(Vec3::Zero(), 0.1, Label::Robot),
                          half_space({0, 0, -0.2}, Vec3::UnitZ(), Label::Ground)};
  int inside = 0;
  for (int i = 0; i < 400; ++i) {
    const Shape limb = capsule(point(), point(), draws.between(0.01, 0.1), Label::Partner);
    const Shape& solid = solids[draws.below(4)];
    const Nearest found = nearest(limb, solid);
    CHECK(found.distance_m == Approx(by_sampling(limb, solid)).margin(2e-4));
    CHECK(found.along >= 0.0);
    CHECK(found.along <= 1.0);
    if (found.distance_m < 0.0) ++inside;
  }
  CHECK(inside > 20);
}

TEST_CASE("out of a box is through its nearest face") {
  const Shape b = box({1, 0, 0}, {0.4, 0.2, 0.1}, 0.0, Label::Robot);
  CHECK(outward(b, {1.0, 0.0, 0.04}).isApprox(Vec3::UnitZ(), 1e-6));
  CHECK(outward(b, {1.0, -0.15, 0.0}).isApprox(-Vec3::UnitY(), 1e-6));
}

TEST_CASE("a palm of a box is a capsule as thick") {
  const Shape palm = as_capsule(box(Vec3::Zero(), {0.07, 0.09, 0.03}, 0.0, Label::Partner));
  CHECK(palm.size[0] == Approx(0.025));
  CHECK(palm.size[1] == Approx(0.04));
  CHECK(palm.X_WS.linear().col(2).isApprox(Vec3::UnitY()));
}

TEST_CASE("a region is known by part, place and side") {
  const Vec3 facing = Vec3::UnitX();
  CHECK(region_of(BodyPart::Head, 0.5, -facing, facing) == BodyRegion::Face);
  CHECK(region_of(BodyPart::Head, 0.5, facing, facing) == BodyRegion::Skull);
  CHECK(region_of(BodyPart::Head, 0.5, -Vec3::UnitZ(), facing) == BodyRegion::Skull);
  CHECK(region_of(BodyPart::Trunk, 0.9, -facing, facing) == BodyRegion::Chest);
  CHECK(region_of(BodyPart::Trunk, 0.1, -facing, facing) == BodyRegion::Abdomen);
  CHECK(region_of(BodyPart::Trunk, 0.9, facing, facing) == BodyRegion::Back);
  CHECK(to_string(BodyRegion::LowerArm) == "lower-arm");
}

TEST_CASE("a mass that meets a free region presses as two bodies and a spring do") {
  // F = v sqrt(mu k), reference page "Power and force": hand 52 N, chest 127 N, skull 177 N at 0.25 m/s
  struct Case {
    BodyRegion region;
    BodyPart part;
    double expected_n;
  };
  for (const Case& c :
       {Case{BodyRegion::Hand, BodyPart::Hand, 52.0}, Case{BodyRegion::LowerArm, BodyPart::LowerArm, 66.0},
        Case{BodyRegion::Chest, BodyPart::Trunk, 127.0},
        Case{BodyRegion::LowerLeg, BodyPart::LowerLeg, 210.0},
        Case{BodyRegion::Skull, BodyPart::Head, 177.0}}) {
    constexpr double kRobot_kg = 14.0, kTick_s = 0.001;
    Shape part;
    part.part = c.part;
    const std::size_t group = group_of(part);
    SoftBody body;
    double x = 0.0, v = 0.25, peak_n = 0.0;
    for (int i = 0; i < 60; ++i) {
      const double depth = x - body.offset(group).x();
      const double n = contact_force_n(properties_of(c.region), depth, v - body.velocity(group).x());
      std::array<Vec3, kBodyGroups> force;
      force.fill(Vec3::Zero());
      force[group].x() = n;
      body.step(force);
      v -= kTick_s * n / kRobot_kg;
      x += kTick_s * v;
      peak_n = std::max(peak_n, n);
    }
    INFO(to_string(c.region));
    CHECK(peak_n == Approx(c.expected_n).epsilon(0.12));
  }
}

TEST_CASE("a hand that was pushed away comes back, and yields to a steady push beyond its strength") {
  Shape hand;
  hand.part = BodyPart::Hand;
  const std::size_t group = group_of(hand);
  SoftBody body;
  std::array<Vec3, kBodyGroups> force;
  force.fill(Vec3::Zero());
  force[group] = Vec3(20.0, 0, 0);
  for (int i = 0; i < 3000; ++i) body.step(force);
  CHECK(body.offset(group).x() == Approx(20.0 / 300.0).epsilon(0.01));
  force[group].setZero();
  for (int i = 0; i < 3000; ++i) body.step(force);
  CHECK(body.offset(group).isZero(0.0));
  force[group] = Vec3(60.0, 0, 0);
  for (int i = 0; i < 500; ++i) body.step(force);
  CHECK(body.offset(group).x() > 0.5);
}
