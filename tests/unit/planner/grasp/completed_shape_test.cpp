#include "planner/hand/completed_shape.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <vector>

namespace colift::planner {
namespace {

using perception::Rectangle;

constexpr double kLength_m = 0.8, kWidth_m = 0.5, kHeight_m = 0.4, kLeg_m = 0.04;

// A face with the given normal; v points up.
Rectangle upright(const Vec3& center, const Vec3& normal, double width_m, double height_m) {
  Rectangle r;
  r.center = center;
  r.normal = normal;
  r.u = Vec3::UnitZ().cross(normal).normalized();
  r.v = Vec3::UnitZ();
  r.size = {width_m, height_m};
  return r;
}

// A table's top and, of each leg that was seen, the two outer faces.
perception::Scene table(const std::vector<Vec3>& legs) {
  perception::Scene scene;
  Rectangle top;
  top.center = {0.0, 0.0, kHeight_m};
  top.normal = Vec3::UnitZ();
  top.u = Vec3::UnitX();
  top.v = Vec3::UnitY();
  top.size = {kLength_m, kWidth_m};
  scene.surfaces.emplace_back(top);
  const double tall_m = kHeight_m - 0.05;
  for (const Vec3& leg : legs) {
    const Vec3 x(leg.x() > 0 ? 1.0 : -1.0, 0.0, 0.0), y(0.0, leg.y() > 0 ? 1.0 : -1.0, 0.0);
    const Vec3 middle(leg.x(), leg.y(), 0.5 * tall_m);
    scene.surfaces.emplace_back(upright(middle + 0.5 * kLeg_m * x, x, kLeg_m, tall_m));
    scene.surfaces.emplace_back(upright(middle + 0.5 * kLeg_m * y, y, kLeg_m, tall_m));
  }
  return scene;
}

Vec3 corner(double x, double y) {
  return {x * 0.5 * (kLength_m - 2 * kLeg_m), y * 0.5 * (kWidth_m - 2 * kLeg_m), 0.0};
}

// What a camera 2 m above the table measures if everything is so far away.
SeenSpace view(float depth_m) {
  hal::DepthFrame frame;
  frame.intrinsics.width = 200;
  frame.intrinsics.height = 200;
  frame.intrinsics.fx = frame.intrinsics.fy = 150.0;
  frame.intrinsics.cx = frame.intrinsics.cy = 100.0;
  frame.depth_m.assign(200 * 200, depth_m);
  hal::Pose X_WC = hal::Pose::Identity();
  X_WC.linear() << 1, 0, 0, 0, -1, 0, 0, 0, -1;
  X_WC.translation() = Vec3(0.0, 0.0, 2.0);
  return {perception::deproject(frame, X_WC), perception::NoiseModel{}, 3.0, 4};
}

bool has_leg(const CompletedSolids& solids, const Vec3& at) {
  return std::any_of(solids.begin(), solids.end(), [&](const CompletedSolid& s) {
    return (s.box.center - at).head<2>().norm() < 0.03 && s.box.size.minCoeff() < 0.1;
  });
}

TEST_CASE("a table has legs at the corners that its top hides, too", "[candidates][completed]") {
  const perception::Scene scene = table({corner(1, -1), corner(1, 1), corner(-1, -1)});
  const SeenSpace from_above = view(2.0F - static_cast<float>(kHeight_m));
  const CompletedSolids solids = complete_solids(scene, &from_above, 0.03, 0.2);
  for (const double x : {-1.0, 1.0})
    for (const double y : {-1.0, 1.0}) CHECK(has_leg(solids, corner(x, y)));
}

TEST_CASE("where the camera looks through there is no leg", "[candidates][completed]") {
  const perception::Scene scene = table({corner(1, -1), corner(1, 1), corner(-1, -1)});
  const SeenSpace through = view(5.0F);
  CHECK_FALSE(has_leg(complete_solids(scene, &through, 0.03, 0.2), corner(-1, 1)));
  CHECK_FALSE(has_leg(complete_solids(scene, nullptr, 0.03, 0.2), corner(-1, 1)));
}

TEST_CASE("a table of whose legs none was seen has none that are known", "[candidates][completed]") {
  const SeenSpace from_above = view(2.0F - static_cast<float>(kHeight_m));
  CHECK(complete_solids(table({}), &from_above, 0.03, 0.2).empty());
}

}  // namespace
}  // namespace colift::planner
