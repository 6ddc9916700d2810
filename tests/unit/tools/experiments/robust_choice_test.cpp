#include <catch2/catch.hpp>
#include <cmath>
#include <memory>
#include <utility>

#include "control/session/decide.hpp"
#include "planner/grasp/robust_choice.hpp"

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

TEST_CASE("what a grasp carries in a what-if is the robot's force of the decision", "[robust]") {
  const auto sharing = LoadSharing::create({});
  UncertainScene s = scene_of(0.0, 0.0);
  s.weight_n = 50.0;
  const std::vector<Vec3> point{{0.6, 0.2, 0.5}};
  const auto w = sharing->wrenches(s.partner - s.cog, point[0] - s.cog, {s.weight_n * s.up, Vec3::Zero()});
  const double carries = w.robot.force.dot(s.up);
  auto robust = RobustChoice::create({}, 1, 10);
  std::vector<RobustCost> free(1), held(1), slips(1);
  robust->evaluate(s, point, free);
  robust->evaluate(s, point, held, std::vector<double>{carries + 1e-9});
  robust->evaluate(s, point, slips, std::vector<double>{carries - 1e-9});
  CHECK(held[0].expected == free[0].expected);
  // the partner alone: the weight, and its torque about his hand
  const Vec3 lever = (s.partner - s.cog).cross(s.up);
  CHECK(slips[0].expected == Approx(1.0 + 400.0 * lever.squaredNorm()).epsilon(1e-9));
}

TEST_CASE("a grip near its limit gives way to one that carries less", "[robust]") {
  // the partner holds near the centre of gravity: nominally the robot takes half, close on the other side
  GraspCandidate near, far;
  UncertainScene s;
  s.partner = {0.15, 0.0, 0.0};
  s.weight_n = 60.0;
  near.position = {-0.15, 0.0, 0.0};
  near.verdict = Verdict::Chosen;
  far.position = {-0.40, 0.0, 0.0};
  auto robust = RobustChoice::create({}, 4);
  const std::vector<GraspCandidate> both{near, far};
  using Aim = RobustChoice::Aim;
  CHECK(robust->choose(s, both, Aim::Expected) == 0u);
  const std::vector<double> holds{31.0, 31.0};
  CHECK(robust->choose(s, both, Aim::Expected, holds) == 0u);
  s.cog_covariance(0, 0) = 0.03 * 0.03;
  CHECK(robust->choose(s, both, Aim::Expected, holds) == 1u);
  // where both slip in any case the nominal choice stays
  CHECK(robust->choose(s, both, Aim::Worst, std::vector<double>{1.0, 1.0}) == 0u);
}

TEST_CASE("decision.robust changes the choice where the nominal grip may slip, and says so", "[robust]") {
  // a block of 6 kg; half of it is just what friction holds, and nobody knows where in it the weight lies
  using namespace colift;
  control::SceneAnalysis analysis;
  perception::Ground ground;
  ground.plane = {Vec3::UnitZ(), 0.0};
  perception::Target target;
  target.cog = {0.0, 0.0, 0.1};
  target.shape.size = {0.8, 0.1, 0.2};
  analysis.scene.ground = ground;
  analysis.scene.target = target;
  control::Config config;
  config.candidates.refine_lines = config.candidates.refine_steps = 0;  // the candidates as they stand
  config.decision.check_reach = false;
  config.decision.mass_kg = 6.0;
  analysis.finder =
      std::make_shared<planner::CandidateFinder>(analysis.scene, nullptr, HandModel{}, config.candidates);
  for (const double x : {-0.15, -0.40}) {
    GraspCandidate c;
    c.id = static_cast<int>(analysis.candidates.size());
    c.position = {x, 0.0, 0.2};
    c.approach = -Vec3::UnitZ();
    c.width = 0.1;
    analysis.candidates.push_back(c);
  }
  perception::PartnerGrasp partner;
  partner.position = {0.15, 0.0, 0.2};
  struct Still final : hal::Clock {
    [[nodiscard]] hal::Timestamp now() const override { return hal::Timestamp(0); }
  } clock;
  const auto choice = [&](const char* robust, double unevenness) {
    config.decision.robust = robust;
    config.decision.unevenness = unevenness;
    auto outcome = control::decide_for(analysis, partner, config, clock);
    REQUIRE(outcome);
    REQUIRE(outcome->decision.chosen);
    const auto& chosen = outcome->candidates[*outcome->decision.chosen];
    CHECK(chosen.verdict == Verdict::Chosen);
    CHECK(chosen.reason == outcome->decision.reason);
    CHECK(outcome->decision.share == outcome->decision.scores[*outcome->decision.chosen]->share);
    return std::pair(chosen.id, outcome->decision.reason);
  };
  CHECK(choice("nominal", 0.05).first == 0);
  CHECK(choice("expected", 0.0).first == 0);
  CHECK(choice("expected", 0.0).second.find("the same over 10000 what-ifs") != std::string::npos);
  const auto [id, reason] = choice("expected", 0.05);
  CHECK(id == 1);
  CHECK(reason.find("candidate 1 has the lowest cost on average over 10000 what-ifs") == 0);
  CHECK(reason.find("with what is believed it would be 0") != std::string::npos);
  CHECK(choice("worst", 0.02).first == 1);
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
