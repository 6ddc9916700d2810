#include <catch2/catch.hpp>
#include <cmath>

#include "tools/visualization/scene/solid_light.hpp"
#include "tools/visualization/scene/solid_scene.hpp"

using namespace colift;
using namespace colift::picture;

namespace {

SolidScene ball_over_ground() {
  SolidScene scene;
  scene.solids.push_back(solid_of(sim_hal::half_space(Vec3::Zero(), Vec3::UnitZ(), sim_hal::Label::Ground)));
  scene.solids.push_back(solid_of(sim_hal::sphere({0.3, 0.1, 0.5}, 0.2, sim_hal::Label::Target)));
  return scene;
}

Colour at(const SolidView& view, const std::vector<std::uint8_t>& rgb, const Vec3& p) {
  const auto px = view.at(p);
  REQUIRE(px);
  const auto i = 3 * (static_cast<std::size_t>(px->y()) * static_cast<std::size_t>(view.width) +
                      static_cast<std::size_t>(px->x()));
  return {rgb[i] / 255.0, rgb[i + 1] / 255.0, rgb[i + 2] / 255.0};
}

}  // namespace

TEST_CASE("a solid is where its view projects it, in perspective and parallel", "[picture]") {
  const SolidScene scene = ball_over_ground();
  SolidView view = view_of(scene, {1.0, -2.0, 1.0}, 320, 200);
  const bool parallel = GENERATE(false, true);
  if (parallel) view.height_m = 1.2;
  view.film = GENERATE(false, true);
  const auto rgb = cast_solids(scene, view);
  REQUIRE(rgb.size() == 3UL * 320 * 200);
  const Vec3 middle(0.3, 0.1, 0.5), ahead = (view.target - view.eye).normalized();
  const Vec3 right = ahead.cross(Vec3::UnitZ()).normalized();
  const auto is_target = [&](const Vec3& p) {
    const Colour c = at(view, rgb, p);
    return c.r > c.b + 0.15;  // its role's colour is a yellow
  };
  CHECK(is_target(middle));
  for (const double side : {-1.0, 1.0}) {
    CHECK(is_target(middle + 0.19 * side * right));
    CHECK_FALSE(is_target(middle + 0.215 * side * right));
  }
  CHECK(rgb == cast_solids(scene, view));
}

TEST_CASE("what stands before the light throws a shadow, and no surface shades itself", "[picture]") {
  sim_hal::World world;
  world.shapes.push_back(sim_hal::box({0, 0, 1.0}, {0.4, 0.4, 0.02}, 0.3, sim_hal::Label::Target));
  const bool coarse = GENERATE(false, true);  // as for one picture of a film
  const SolidLights lights(world, Vec3f::UnitZ(), coarse);
  const Vec3f up = Vec3f::UnitZ();
  const std::vector<SurfacePoint> points{{Vec3f(0, 0, 0.5f), up},            // beneath the plate
                                         {Vec3f(0, 0, 1.01f), up},           // on it
                                         {Vec3f(1, 0, 0), up},               // beside it
                                         {Vec3f(0, 0, 0.99f), Vec3f(-up)}};  // its lower side
  const auto light = lights.at(points);
  CHECK(light[0].key == 0.0f);
  CHECK(light[0].sky < 0.95f);
  CHECK(light[1].key == 1.0f);
  CHECK(light[1].sky > 0.99f);
  CHECK(light[2].key == 1.0f);
  CHECK(light[3].key == 0.0f);

  const SolidLights nothing(sim_hal::World{}, Vec3f::UnitZ(), coarse);
  const auto open = nothing.at(points);
  CHECK(open[0].key == 1.0f);
  CHECK(open[0].sky == 1.0f);
}
