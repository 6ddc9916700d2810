// Ladders are carried by two, and are no persons: as they were drawn for `colift experiment furniture --seed
// 263`.
#include <cmath>
#include <numbers>

#include "lying_person.hpp"
#include "seen_object.hpp"

namespace colift::perception {
namespace {

using namespace sim_hal;

constexpr double kDegree = std::numbers::pi / 180.0;

// a part of a ladder, in the ladder's frame, leaning about its own y axis
struct Part {
  Vec3 size, at;
  double lean_deg = 0.0;
};
std::vector<Shape> ladder(const std::vector<Part>& parts, const Vec3& at, double yaw_deg) {
  std::vector<Shape> shapes;
  Pose X_WL = Pose::Identity();
  X_WL.translate(at).rotate(Eigen::AngleAxisd(yaw_deg * kDegree, Vec3::UnitZ()));
  for (const Part& part : parts) {
    Shape shape = box(Vec3::Zero(), part.size, 0.0, Label::Target);
    shape.X_WS = X_WL;
    shape.X_WS.translate(part.at).rotate(Eigen::AngleAxisd(part.lean_deg * kDegree, Vec3::UnitY()));
    shapes.push_back(shape);
  }
  return shapes;
}

// on one rail, `height` above the floor with the upper one
SeenObject on_one_rail(int rungs, double height_m, std::uint64_t seed) {
  const Vec3 rail(1.124, 0.072, 0.029);
  std::vector<Part> parts{{rail, {0, 0, 0.5 * rail.z()}}, {rail, {0, 0, height_m - 0.5 * rail.z()}}};
  for (int n = 0; n < rungs; ++n)
    parts.push_back({{0.03, 0.03, height_m - 0.04}, {0.281 * (n - 0.5 * (rungs - 1)), 0, 0.5 * height_m}});
  return SeenObject(ladder(parts, {1.109, 0.093, 0}, 9.9), seed,
                    look_at({1.126, -1.393, 1.465}, {1.02, 0.14, 0.233}), kFrames, kRaised_m);
}

SeenObject stepladder(std::uint64_t seed) {
  const Vec3 rail(0.039, 0.026, 0.913), step(0.07, 0.328, 0.025);
  return SeenObject(ladder({{rail, {-0.125, -0.177, 0.445}, 15.6},
                            {rail, {0.125, -0.177, 0.445}, -15.6},
                            {rail, {-0.125, 0.177, 0.445}, 15.6},
                            {rail, {0.125, 0.177, 0.445}, -15.6},
                            {step, {-0.187, 0, 0.223}},
                            {step, {-0.125, 0, 0.445}},
                            {step, {-0.062, 0, 0.668}},
                            {{0.02, 0.328, 0.03}, {0.1, 0, 0.534}},
                            {{0.14, 0.38, 0.03}, {0, 0, 0.89}}},
                           {0.818, -0.062, 0}, 0.4),
                    seed, look_at({0.57, 1.442, 1.479}, {0.749, -0.018, 0.543}), kFrames, kRaised_m);
}

int openings(const SeenObject& seen, double min_area_m2) {
  return count_openings(seen.cloud, seen.components, seen.object, min_area_m2);
}

}  // namespace

TEST_CASE("a ladder that lies on one rail surrounds the floor between its rungs, and is no limb",
          "[person]") {
  LimbShapeConfig without;
  without.max_frame_height_m = 0.0;
  CHECK(of_ten([&](std::uint64_t seed) { return on_one_rail(4, 0.388, seed).limb(without).has_value(); }) >
        0);
  CHECK(of_ten([&](std::uint64_t seed) { return on_one_rail(4, 0.388, seed).limb().has_value(); }) == 0);
}

TEST_CASE("who lies on his back with his hands behind his head surrounds the floor twice, and is no ladder",
          "[person]") {
  const std::vector<Shape> person = lying_person({1.2, 0, 0}, true);
  const Pose above = look_at({0.6, 0.2, 2.2}, {1.2, 0, 0.1});
  const SeenObject seen(person, 1, above, kFrames, kRaised_m);
  CHECK(openings(seen, 0.004) >= 2);
  CHECK(of_ten([&](std::uint64_t seed) {
          return SeenObject(person, seed, above, kFrames, kRaised_m).limb().has_value();
        }) == 10);
}

TEST_CASE("openings through a frame are counted where they are wide enough", "[person]") {
  const SeenObject seen = on_one_rail(4, 0.388, 1);
  CHECK(openings(seen, 0.004) == 3);
  CHECK(openings(seen, 0.5) == 0);
  CHECK(count_openings(seen.cloud, seen.components, Fragment(), 0.0) == 0);
}

TEST_CASE("a stepladder seen from its side has a top and rails, and no head on a torso", "[person]") {
  PersonShapeConfig without;
  without.min_torso_thickness_m = without.min_head_arch_m = 0.0;
  CHECK(of_ten([&](std::uint64_t seed) { return stepladder(seed).person(without).has_value(); }) > 0);
  CHECK(of_ten([&](std::uint64_t seed) { return stepladder(seed).person().has_value(); }) == 0);
}

}  // namespace colift::perception
