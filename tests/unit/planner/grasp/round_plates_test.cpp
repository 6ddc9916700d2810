#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <vector>

#include "planner/grasp/grasp_candidates.hpp"
#include "seen_scene.hpp"

namespace colift::planner {
namespace {

constexpr double kTop_m = 0.45, kThick_m = 0.025;

/// Rims of a plate on one foot, of which perception says that it is a rectangle.
std::vector<GraspLine> rims_of(const sim_hal::Shape& plate, const Eigen::Vector2d& size, bool noise) {
  auto seen = tests::see(
      tests::scene_of({plate, sim_hal::box({0, 0, 0.2}, {0.06, 0.06, 0.4}, 0.0, sim_hal::Label::Target)},
                      {0.9, -1.2, 1.3}, {0, 0, 0.35}),
      noise);
  perception::Rectangle top;
  top.center = {0.02, -0.01, kTop_m};
  top.normal = Vec3::UnitZ();
  top.u = Vec3::UnitX();
  top.v = Vec3::UnitY();
  top.size = size;
  seen.scene.surfaces.assign({top});
  const CandidateFinder finder(seen.scene, &seen.cloud, HandModel{}, CandidateConfig{});
  std::vector<GraspLine> rims;
  // those of the rectangle's own edges lie along its axes
  std::copy_if(finder.lines().begin(), finder.lines().end(), std::back_inserter(rims),
               [](const GraspLine& line) {
                 return line.kind == GraspKind::Edge && line.approach.head<2>().cwiseAbs().minCoeff() > 0.01;
               });
  return rims;
}

}  // namespace

TEST_CASE("a round plate is grasped all around its rim, towards its middle", "[candidates]") {
  const double radius = GENERATE(0.18, 0.3);
  const bool noise = GENERATE(false, true);
  const auto rims = rims_of(sim_hal::cylinder({0, 0, kTop_m - 0.5 * kThick_m}, Vec3::UnitZ(), radius,
                                              kThick_m, sim_hal::Label::Target),
                            {1.9 * radius, 1.8 * radius}, noise);
  INFO("radius " << radius << (noise ? ", with noise" : ""));
  REQUIRE(rims.size() >= 16);
  std::vector<double> angles;
  for (const GraspLine& rim : rims) {
    const Vec3 out(rim.from.x(), rim.from.y(), 0.0);
    CHECK(out.norm() == Approx(radius).margin(0.012));
    CHECK(rim.approach.dot(out.normalized()) < -0.99);
    CHECK(rim.width == Approx(kThick_m).margin(0.012));
    CHECK(rim.from.z() == Approx(kTop_m - 0.5 * rim.width).margin(0.005));
    angles.push_back(std::atan2(out.y(), out.x()));
  }
  std::sort(angles.begin(), angles.end());
  for (std::size_t i = 1; i < angles.size(); ++i) CHECK(angles[i] - angles[i - 1] < 0.75);
}

TEST_CASE("a plate with corners has no round rim", "[candidates]") {
  using sim_hal::box;
  CHECK(rims_of(box({0, 0, kTop_m - 0.5 * kThick_m}, {0.5, 0.5, kThick_m}, 0.0, sim_hal::Label::Target),
                {0.5, 0.5}, true)
            .empty());
  CHECK(rims_of(box({0, 0, kTop_m - 0.5 * kThick_m}, {0.6, 0.45, kThick_m}, 0.4, sim_hal::Label::Target),
                {0.55, 0.42}, true)
            .empty());
}

}  // namespace colift::planner
