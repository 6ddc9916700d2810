#include <catch2/catch.hpp>

#include "views.hpp"

using namespace colift;
using namespace colift::perception;
using sim_hal::box;
using sim_hal::Label;

namespace {

/// Part of a rectangle's area at which there is nothing of the object within 2 cm behind or before it.
double hollow_part(const Rectangle& r, const sim_hal::World& world) {
  constexpr int kSteps = 24;
  int hollow = 0;
  for (int i = 0; i < kSteps; ++i)
    for (int j = 0; j < kSteps; ++j) {
      const Vec3 p = r.center + r.size.x() * ((i + 0.5) / kSteps - 0.5) * r.u +
                     r.size.y() * ((j + 0.5) / kSteps - 0.5) * r.v;
      hollow += sim_hal::distance(world, Label::Target, p) > 0.02;
    }
  return static_cast<double>(hollow) / (kSteps * kSteps);
}

}  // namespace

TEST_CASE(
    "no rectangle lies over the space between a table's legs, in an open box or between a chair's slats",
    "[surfaces]") {
  using sim_hal::ObjectKind;
  for (const ObjectKind kind : {ObjectKind::Table, ObjectKind::OpenBox, ObjectKind::Chair})
    for (std::uint64_t seed = 1; seed <= 12; ++seed) {
      const SurfaceView view(kind, seed);
      for (const Rectangle& r : rectangles_of(view.surfaces())) {
        INFO(view.scene.name << ", rectangle " << r.size.transpose() << " at " << r.center.transpose());
        CHECK(hollow_part(r, view.scene.world) < 0.35);
      }
    }
}

TEST_CASE("an upright frame becomes its four bars", "[surfaces]") {
  const SurfaceView view(scene_of({box({0, 0, 0.55}, {0.03, 0.8, 0.10}, 0, Label::Target),
                                   box({0, 0, 0.05}, {0.03, 0.8, 0.10}, 0, Label::Target),
                                   box({0, 0.35, 0.3}, {0.03, 0.1, 0.4}, 0, Label::Target),
                                   box({0, -0.35, 0.3}, {0.03, 0.1, 0.4}, 0, Label::Target)},
                                  {1.5, 0.2, 0.8}, {0, 0, 0.3}),
                         1);
  int bars = 0;
  for (const Rectangle& r : rectangles_of(view.surfaces())) {
    if (r.normal.x() < 0.9) continue;
    CHECK(hollow_part(r, view.scene.world) < 0.25);
    bars += r.size.y() > 0.05 && r.size.y() < 0.14 && r.size.x() > 0.3;
  }
  CHECK(bars == 4);
}

TEST_CASE("what the camera could not see does not split a face", "[surfaces]") {
  SurfaceView view(
      scene_of({box({0, 0, 0.25}, {0.5, 0.5, 0.5}, 0.4, Label::Target)}, {1.2, 0.4, 1.4}, {0, 0, 0.3}), 1);
  // a dark patch in the middle of the top
  std::vector<std::uint32_t> kept;
  for (const std::uint32_t k : view.target.pixels) {
    const Vec3 p = view.cloud.point(k);
    if (p.z() > 0.48 && p.head<2>().norm() < 0.12)
      view.cloud.depth_m[k] = view.cloud.x[k] = view.cloud.y[k] = view.cloud.z[k] = NAN;
    else
      kept.push_back(k);
  }
  REQUIRE(kept.size() + 2000 < view.target.pixels.size());
  view.target.pixels = kept;
  int tops = 0;
  for (const Rectangle& r : rectangles_of(view.surfaces()))
    if (r.normal.z() > 0.99) {
      ++tops;
      CHECK(r.size.x() == Approx(0.5).margin(0.012));
      CHECK(r.size.y() == Approx(0.5).margin(0.012));
    }
  CHECK(tops == 1);
}
