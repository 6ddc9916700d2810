#include "planner/motion/collision/collision_spheres.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>

#include "sim_hal/synthetic/hash_random.hpp"

namespace {

using namespace colift;
using hal::LinkShape;
using hal::Vec3;

/// A random point of the solid; every second one on its surface.
Vec3 draw_in(const LinkShape& shape, sim_hal::Draws& draws) {
  const bool on_surface = draws.chance(0.5);
  const Vec3& s = shape.size;
  Vec3 p(draws.between(-1, 1), draws.between(-1, 1), draws.between(-1, 1));
  if (shape.kind == LinkShape::Kind::Box) {
    if (on_surface) p[draws.below(3)] = draws.chance(0.5) ? 1.0 : -1.0;
    if (draws.chance(0.1)) p = p.unaryExpr([](double v) { return v < 0 ? -1.0 : 1.0; });
    return shape.X_LS * (0.5 * s.cwiseProduct(p));
  }
  if (shape.kind == LinkShape::Kind::Cylinder) {
    const double turn = std::numbers::pi * p.x();
    const double radius = s[0] * (on_surface ? 1.0 : std::sqrt(std::abs(p.y())));
    if (draws.chance(0.2)) p.z() = p.z() < 0 ? -1.0 : 1.0;
    return shape.X_LS * Vec3(radius * std::cos(turn), radius * std::sin(turn), 0.5 * s[1] * p.z());
  }
  const double radius = s[0] * (on_surface ? 1.0 : std::abs(p.x()));
  return shape.X_LS * (radius * (p.norm() > 0 ? Vec3(p.normalized()) : Vec3::UnitX().eval()));
}

LinkShape draw_shape(sim_hal::Draws& draws) {
  LinkShape shape;
  shape.kind = static_cast<LinkShape::Kind>(draws.below(3));
  shape.size = {draws.between(0.005, 0.15), draws.between(0.005, 0.5), draws.between(0.005, 0.3)};
  shape.X_LS.translate(Vec3(draws.between(-0.2, 0.2), 0.1, draws.between(-0.2, 0.2)));
  shape.X_LS.rotate(Eigen::AngleAxisd(draws.between(-3, 3), Vec3(1, 2, draws.between(-3, 3)).normalized()));
  return shape;
}

bool covered(const Vec3& p, const std::vector<std::pair<Vec3, double>>& spheres) {
  return std::any_of(spheres.begin(), spheres.end(),
                     [&](const auto& s) { return (p - s.first).norm() <= s.second; });
}

}  // namespace

TEST_CASE("every point in and on any shape lies in one of its spheres") {
  sim_hal::Draws draws(1, 1);
  for (int i = 0; i < 400; ++i) {
    const LinkShape shape = draw_shape(draws);
    std::vector<std::pair<Vec3, double>> spheres;
    planner::cover_shape(shape, draws.between(0.004, 0.03), spheres);
    REQUIRE_FALSE(spheres.empty());
    for (int k = 0; k < 200; ++k) REQUIRE(covered(draw_in(shape, draws), spheres));
  }
}

TEST_CASE("spheres stand out of boxes and of the sides of cylinders by no more than asked for") {
  const double excess = 0.0115;
  for (const Vec3& size : {Vec3(0.09, 0.09, 0.06), Vec3(0.08, 0.02, 0.02), Vec3(0.02, 0.04, 0.04)}) {
    LinkShape shape;
    shape.size = size;
    std::vector<std::pair<Vec3, double>> spheres;
    planner::cover_shape(shape, excess, spheres);
    for (const auto& [center, radius] : spheres) {
      CHECK((center.cwiseAbs() + Vec3::Constant(radius) - 0.5 * size).maxCoeff() <= excess + 1e-5);
    }
  }
  LinkShape cylinder;
  cylinder.kind = LinkShape::Kind::Cylinder;
  cylinder.size = {0.06, 0.17, 0.0};
  std::vector<std::pair<Vec3, double>> spheres;
  planner::cover_shape(cylinder, excess, spheres);
  for (const auto& [center, radius] : spheres) {
    CHECK(center.head<2>().norm() + radius <= 0.06 + excess + 1e-5);
  }
}

TEST_CASE("the robot is covered by 60 to 120 spheres, links ascending") {
  const hal::RobotModel& robot = hal::built_in_robot();
  const planner::SphereModel model = planner::cover_with_spheres(robot);
  CHECK(model.spheres.size() >= 60);
  CHECK(model.spheres.size() <= 120);
  CHECK(std::is_sorted(model.spheres.begin(), model.spheres.end(),
                       [](const auto& a, const auto& b) { return a.link < b.link; }));
  sim_hal::Draws draws(2, 1);
  for (std::size_t l = 0; l < robot.links.size(); ++l) {
    std::vector<std::pair<Vec3, double>> spheres;
    for (const auto& s : model.spheres) {
      if (s.link == static_cast<int>(l)) spheres.emplace_back(s.center_L, s.radius_m);
    }
    for (const LinkShape& shape : robot.links[l].shapes) {
      for (int k = 0; k < 300; ++k) REQUIRE(covered(draw_in(shape, draws), spheres));
    }
  }
}

TEST_CASE("self pairs name the hand with base and forearm, and no neighbours") {
  const hal::RobotModel& robot = hal::built_in_robot();
  const planner::SphereModel model = planner::cover_with_spheres(robot);
  const std::vector<int> body = planner::arm_body(robot);
  CHECK(body[static_cast<std::size_t>(robot.palm)] == 7);
  CHECK(body[static_cast<std::size_t>(robot.arm[3])] == 4);
  bool base = false, forearm = false;
  for (const auto& [a, b] : model.self_pairs) {
    const int low = body[static_cast<std::size_t>(a)];
    CHECK(a < b);
    CHECK(planner::may_meet(robot, body, a, b));
    base |= low == 0 && b == robot.palm;
    forearm |= low == 4 && robot.in_hand(b);
  }
  CHECK(base);
  CHECK(forearm);
}
