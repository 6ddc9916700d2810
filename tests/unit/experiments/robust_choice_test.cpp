#include <catch2/catch.hpp>
#include <cmath>

#include "planner/robust_choice.hpp"

using namespace colift::planner;

namespace {

UncertainScene scene_of(double cog_sigma, double partner_sigma) {
  UncertainScene s;
  s.cog = {0.9, 0.05, 0.3};
  s.partner = {1.3, 0.1, 0.4};
  s.cog_covariance = cog_sigma * cog_sigma * Eigen::Matrix3d::Identity();
  s.partner_covariance = partner_sigma * partner_sigma * Eigen::Matrix3d::Identity();
  return s;
}

}  // namespace

TEST_CASE("without uncertainty every what-if is the load sharing of the thesis", "[robust]") {
  for (const SharingWeights& weights :
       {SharingWeights{}, SharingWeights{0.7, 5.0, 9.0}, SharingWeights::thesis()}) {
    auto robust = RobustChoice::create(weights, 8, 100);
    REQUIRE(robust);
    UncertainScene s = scene_of(0.0, 0.0);
    s.up = Vec3(0.1, -0.2, 1.0).normalized();
    const std::vector<Vec3> points{{0.5, 0.0, 0.3}, {0.6, 0.3, 0.5}, {0.9, -0.2, 0.1}};
    std::vector<RobustCost> costs(points.size());
    robust->evaluate(s, points, costs);
    const auto sharing = LoadSharing::create(weights);
    for (std::size_t i = 0; i < points.size(); ++i) {
      const double exact = sharing->cost(s.partner - s.cog, points[i] - s.cog, {s.up, Vec3::Zero()});
      CHECK(costs[i].expected == Approx(exact).epsilon(1e-12));
      CHECK(costs[i].worst == Approx(exact).epsilon(1e-12));
    }
  }
}

TEST_CASE("expected and worst cost grow with what is not known", "[robust]") {
  auto robust = RobustChoice::create({}, 1);
  REQUIRE(robust);
  const std::vector<Vec3> point{{0.5, 0.0, 0.3}};
  std::vector<RobustCost> sure(1), unsure(1), more(1);
  robust->evaluate(scene_of(0.0, 0.0), point, sure);
  robust->evaluate(scene_of(0.03, 0.01), point, unsure);
  robust->evaluate(scene_of(0.06, 0.02), point, more);
  CHECK(sure[0].expected < unsure[0].expected);
  CHECK(unsure[0].expected < more[0].expected);
  CHECK(unsure[0].worst > unsure[0].expected);
  // twice the deviation, four times the expected excess, as long as the hands are far apart
  CHECK(more[0].expected - sure[0].expected ==
        Approx(4.0 * (unsure[0].expected - sure[0].expected)).epsilon(0.1));
}

TEST_CASE("where the centre of gravity may lie along the line, the wider stance is the robust one",
          "[robust]") {
  // beside the line no stance helps: that torque both hands hold, wherever they are
  GraspCandidate near, far;
  UncertainScene s;
  s.partner = {0.4, 0.0, 0.0};
  s.cog_covariance(0, 0) = 0.05 * 0.05;
  near.position = {-0.40, 0.0, 0.0};
  far.position = {-0.41, 0.0, 0.0};
  auto robust = RobustChoice::create({}, 4);
  REQUIRE(robust);
  const std::vector<GraspCandidate> both{near, far};
  // nominally the nearer one is the optimum
  const auto sharing = LoadSharing::create({});
  const Wrench lift{Vec3::UnitZ(), Vec3::Zero()};
  CHECK(sharing->cost(s.partner, near.position, lift) < sharing->cost(s.partner, far.position, lift));
  std::vector<RobustCost> costs(2);
  robust->evaluate(s, std::vector<Vec3>{near.position, far.position}, costs);
  CHECK(costs[1].expected < costs[0].expected);
  CHECK(robust->choose(s, both, RobustChoice::Aim::Expected) == 1u);
}

TEST_CASE("refused candidates are never chosen, and more than fit are taken in turns", "[robust]") {
  std::vector<GraspCandidate> all(7);
  for (std::size_t i = 0; i < all.size(); ++i) {
    all[i].position = {-0.1 * static_cast<double>(i), 0.0, 0.0};
    all[i].verdict = i == 4 ? Verdict::Collision : Verdict::Ok;
  }
  UncertainScene s;
  s.partner = {0.4, 0.0, 0.0};
  auto robust = RobustChoice::create({}, 3, 1000);
  REQUIRE(robust);
  const auto best = robust->choose(s, all, RobustChoice::Aim::Expected);
  REQUIRE(best);
  CHECK((*best == 3 || *best == 5));
  for (auto& c : all) c.verdict = Verdict::Unreachable;
  CHECK_FALSE(robust->choose(s, all, RobustChoice::Aim::Expected));
}

TEST_CASE("nonsense is refused", "[robust]") {
  CHECK_FALSE(RobustChoice::create({}, 0));
  CHECK_FALSE(RobustChoice::create({}, 1, 0));
  CHECK_FALSE(RobustChoice::create({-1.0, 1.0, 1.0}, 1));
}
