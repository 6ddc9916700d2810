#include "control/session/suggest.hpp"

#include <catch2/catch.hpp>

using namespace colift;
using namespace colift::control;

namespace {

/// Places around the rim of a table top, 0.8 m x 0.6 m, 0.5 m high. The robot reaches the end at x < 0.
std::vector<planner::GraspCandidate> rim() {
  std::vector<planner::GraspCandidate> all;
  for (const double x : {-0.4, 0.4})
    for (double y = -0.3; y < 0.31; y += 0.1) {
      planner::GraspCandidate c;
      c.position = {x, y, 0.5};
      if (x > 0.0) c.verdict = planner::Verdict::Unreachable;
      all.push_back(c);
    }
  planner::GraspCandidate foot;
  foot.position = {0.4, 0.0, 0.05};
  foot.verdict = planner::Verdict::Unreachable;
  all.push_back(foot);
  return all;
}

const hal::Vec3 kCog(0.0, 0.0, 0.45), kUp = hal::Vec3::UnitZ();

Outcome decided_for(const hal::Vec3& partner, const planner::DecisionConfig& config) {
  Outcome outcome;
  outcome.partner = perception::PartnerGrasp{partner, Eigen::Matrix3d::Zero(), 100, {}};
  outcome.candidates = rim();
  auto decision = planner::decide_grasp(outcome.candidates, {*outcome.partner, kCog, kUp, false}, config);
  REQUIRE(decision);
  outcome.decision = std::move(*decision);
  return outcome;
}

}  // namespace

TEST_CASE("who holds the table at its side is told to go to the end across from the robot") {
  const planner::DecisionConfig config;
  const hal::Vec3 at_side(0.0, 0.3, 0.5);
  const Outcome outcome = decided_for(at_side, config);
  REQUIRE(outcome.decision.chosen);
  const auto better = suggest_to_partner(outcome, rim(), kCog, kUp, config);
  REQUIRE(better);
  CHECK(better->position.x() == Approx(0.4));
  CHECK(better->position.z() == Approx(0.5));  // not at a foot
  REQUIRE(better->gain);
  CHECK(*better->gain > 0.5);
  // and what he is promised is what he gets
  const Outcome there = decided_for(better->position, config);
  CHECK(there.decision.cost == Approx(outcome.decision.cost * (1.0 - *better->gain)));
  CHECK_FALSE(suggest_to_partner(there, rim(), kCog, kUp, config));
}

TEST_CASE("where the robot has no grasp the partner is told with which place it would have one") {
  planner::DecisionConfig config;
  config.max_lever_m = 0.065;
  const Outcome outcome = decided_for({0.0, 0.3, 0.5}, config);
  REQUIRE_FALSE(outcome.decision.chosen);
  const auto better = suggest_to_partner(outcome, rim(), kCog, kUp, config);
  REQUIRE(better);
  CHECK_FALSE(better->gain);
  CHECK_THAT(better->reason, Catch::Contains("the robot could"));
  CHECK(decided_for(better->position, config).decision.chosen);
}

TEST_CASE("nobody is told anything without a partner, without candidates, or where torque costs nothing") {
  planner::DecisionConfig config;
  Outcome outcome = decided_for({0.0, 0.3, 0.5}, config);
  CHECK_FALSE(suggest_to_partner(outcome, {}, kCog, kUp, config));
  config.weights.omega1_per_m = config.weights.omega2_per_m = 0.0;
  CHECK_FALSE(suggest_to_partner(outcome, rim(), kCog, kUp, config));
  outcome.partner.reset();
  CHECK_FALSE(suggest_to_partner(outcome, rim(), kCog, kUp, planner::DecisionConfig{}));
}
