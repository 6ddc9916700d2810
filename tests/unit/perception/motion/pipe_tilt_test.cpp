#include "perception/motion/pipe_tilt.hpp"

#include <catch2/catch.hpp>

#include "hal/types/units.hpp"

namespace colift::perception {
namespace {

Scene pipe_on_blocks(const Vec3& axis) {
  Scene scene;
  scene.surfaces = {Rectangle{}, Cylinder{Vec3::Zero(), axis, 0.03, 1.2}};
  scene.target.emplace();
  scene.target->shape.size = Vec3(1.2, 0.06, 0.06);
  scene.target->obb.size = Vec3(1.2, 0.15, 0.4);
  return scene;
}

hal::Pose turned(double deg, const Vec3& about) {
  return hal::Pose(Eigen::AngleAxisd(hal::deg_to_rad(deg), about));
}

}  // namespace

TEST_CASE("a pipe that turns about its axis stays level, one whose end rises does not", "[motion]") {
  const Vec3 axis = Vec3(1.0, 0.2, 0.1).normalized(), up = Vec3::UnitZ();
  const auto found = pipe_axis(pipe_on_blocks(axis));
  REQUIRE(found);
  CHECK((*found - axis).norm() < 1e-12);
  CHECK(slope_change(turned(25.0, axis), axis, up) < 1e-9);
  CHECK(slope_change(turned(25.0, up), axis, up) < 1e-9);
  CHECK(slope_change(turned(3.0, axis.cross(up).normalized()), axis, up) == Approx(hal::deg_to_rad(3.0)));
}

TEST_CASE("what was not completed as its cylinder has no axis", "[motion]") {
  Scene scene = pipe_on_blocks(Vec3::UnitX());
  scene.target->shape.size = Vec3(1.2, 0.5, 0.4);  // a table with a round leg
  CHECK_FALSE(pipe_axis(scene));
  scene.target.reset();
  CHECK_FALSE(pipe_axis(scene));
}

}  // namespace colift::perception
