// "Why not that one?" has an answer for every candidate.

#include <catch2/catch.hpp>

#include "tools/analyse/decide_why.hpp"

using namespace colift;
using planner::Verdict;

namespace {

// a table edge with three grasps and one that would collide; the partner opposite
control::Outcome decided(const control::Config& config) {
  control::Outcome o;
  for (int i = 0; i < 4; ++i) {
    planner::GraspCandidate c;
    c.id = i;
    c.position = {-0.4, 0.1 * i, 0.0};
    c.verdict = i == 3 ? Verdict::Collision : Verdict::Ok;
    c.reason = i == 3 ? "palm meets the table top 14 mm inside" : "";
    o.candidates.push_back(c);
  }
  planner::DecisionInput input;
  input.partner.position = {0.4, 0.0, 0.0};
  auto decision = planner::decide_grasp(o.candidates, input, config.decision);
  REQUIRE(decision);
  o.decision = *decision;
  return o;
}

}  // namespace

TEST_CASE("the terms of a candidate's cost add up", "[why]") {
  control::Config config;
  config.decision.weights = {0.8, 10.0, 20.0};
  config.decision.max_sideways = 10.0;
  const control::Outcome o = decided(config);
  for (int id = 0; id < 4; ++id) {
    const auto why = tools::explain_candidate(o, config, id);
    REQUIRE(why);
    REQUIRE(why->scored);
    CHECK(why->partner_force + why->partner_torque + why->robot_force + why->robot_torque ==
          Approx(why->cost).epsilon(1e-9));
    CHECK(why->possible == 3);
  }
}

TEST_CASE("what stands against a candidate is said in its own words", "[why]") {
  control::Config config;
  config.decision.max_sideways = 10.0;
  const control::Outcome o = decided(config);
  const auto best = tools::explain_candidate(o, config, 0), worse = tools::explain_candidate(o, config, 2),
             hit = tools::explain_candidate(o, config, 3);
  REQUIRE((best && worse && hit));
  CHECK(best->rank == 1);
  CHECK(best->text.find("feasible, and the lowest cost") != std::string::npos);
  CHECK(worse->rank == 3);
  CHECK(worse->text.find("% more, mostly for") != std::string::npos);
  CHECK(hit->rank == 0);
  CHECK(hit->text.find("palm meets the table top 14 mm inside") != std::string::npos);
  const std::string document = tools::with_why(R"({"schema":"colift.decide/1"})", o, *worse);
  CHECK(document.find("\"why\":{\"candidate\":2") != std::string::npos);
  CHECK(document.find("\"rank\":3") != std::string::npos);
}

TEST_CASE("a candidate that is none is refused with the ids that there are", "[why]") {
  control::Config config;
  const auto why = tools::explain_candidate(decided(config), config, 9);
  REQUIRE_FALSE(why);
  CHECK(why.error().code == hal::ErrorCode::BadInput);
  CHECK(why.error().detail.find("0 to 3") != std::string::npos);
}
