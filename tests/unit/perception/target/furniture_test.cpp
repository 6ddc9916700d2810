// Furniture that has something of a person: as it was drawn for scenarios of bodies that no generator makes.
#include <cmath>
#include <numbers>

#include "seen_object.hpp"

namespace colift::perception {
namespace {

using namespace sim_hal;

constexpr double kDegree = std::numbers::pi / 180.0;

Shape part(const Vec3& at, const Vec3& size) {
  return box(at, size, 0.0, Label::Target);
}

// Its back, seen from the edge, over its arms.
SeenObject armchair(std::uint64_t seed) {
  std::vector<Shape> shapes{part({1.0, 0, 0.40}, {0.50, 0.55, 0.10}),
                            part({1.25, 0, 0.65}, {0.06, 0.55, 0.45})};
  for (const double side : {-1.0, 1.0}) {
    shapes.push_back(part({1.0, 0.27 * side, 0.55}, {0.50, 0.05, 0.20}));
    for (const double x : {0.78, 1.22}) shapes.push_back(part({x, 0.24 * side, 0.175}, {0.04, 0.04, 0.35}));
  }
  return {shapes, seed, look_at({1.2, -1.9, 1.6}, {1.0, 0, 0.4}), kFrames, kRaised_m};
}

// A beam of 9 cm: no piece of its surface lies on one face only.
SeenObject trestle(std::uint64_t seed) {
  std::vector<Shape> shapes{part({1.25, 0, 0.70}, {1.0, 0.09, 0.09})};
  for (const double x : {0.85, 1.65}) {
    for (const double side : {-1.0, 1.0}) {
      Shape leg = part(Vec3::Zero(), {0.05, 0.05, 0.72});
      leg.X_WS = Pose::Identity();
      leg.X_WS.translate(Vec3(x, 0.15 * side, 0.345))
          .rotate(Eigen::AngleAxisd(22 * side * kDegree, Vec3::UnitX()));
      shapes.push_back(leg);
    }
  }
  return {shapes, seed, look_at({2.1, -1.4, 1.5}, {1.15, 0, 0.3}), kFrames, kRaised_m};
}

SeenObject drum(std::uint64_t seed) {
  const Vec3 middle(0.95, 0, 0.30), lid(0.95, 0, 0.6075);
  return {{cylinder(middle, Vec3::UnitZ(), 0.12, 0.60, Label::Target),
           cylinder(lid, Vec3::UnitZ(), 0.16, 0.015, Label::Target)},
          seed,
          look_at({2.1, -1.4, 1.5}, {1.15, 0, 0.3}),
          kFrames,
          kRaised_m};
}

// Stands as wide as three pipes: its widths along it say nothing.
SeenObject pipe_on_stands(std::uint64_t seed) {
  std::vector<Shape> shapes{cylinder({0, 0, 0.259}, Vec3::UnitX(), 0.0593, 1.332, Label::Target)};
  for (const double side : {-1.0, 1.0}) shapes.push_back(part({0.33 * side, 0, 0.1}, {0.172, 0.133, 0.2}));
  return {shapes, seed, look_at({-1.673, 0.712, 1.296}, {0, 0, 0.2}), kFrames, kRaised_m};
}

}  // namespace

TEST_CASE("the back of an armchair, seen from its edge, is level on top, and no head", "[person]") {
  PersonShapeConfig without;
  without.min_head_arch_m = 0.0;
  // pixels at the edge of the back still make a dome of it in two of ten frames
  CHECK(of_ten([&](std::uint64_t seed) { return armchair(seed).person(without).has_value(); }) >= 8);
  CHECK(of_ten([&](std::uint64_t seed) { return armchair(seed).person().has_value(); }) <= 3);
}

TEST_CASE("a trestle's beam on its legs is no limb", "[person]") {
  LimbShapeConfig without;
  without.min_beam_length_m = 10.0;
  CHECK(of_ten([&](std::uint64_t seed) { return trestle(seed).limb(without).has_value(); }) > 0);
  CHECK(of_ten([&](std::uint64_t seed) { return trestle(seed).limb().has_value(); }) == 0);
}

TEST_CASE("a pipe on two stands is no limb: the floor is seen under it", "[person]") {
  LimbShapeConfig without;
  without.min_beam_length_m = 10.0;
  CHECK(of_ten([&](std::uint64_t seed) { return pipe_on_stands(seed).limb(without).has_value(); }) > 0);
  CHECK(of_ten([&](std::uint64_t seed) { return pipe_on_stands(seed).limb().has_value(); }) == 0);
}

TEST_CASE("a drum under its lid is no limb", "[person]") {
  LimbShapeConfig without;
  without.min_top_width_m = 10.0;
  CHECK(of_ten([&](std::uint64_t seed) { return drum(seed).limb(without).has_value(); }) > 0);
  CHECK(of_ten([&](std::uint64_t seed) { return drum(seed).limb().has_value(); }) == 0);
}

}  // namespace colift::perception
