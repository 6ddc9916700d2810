#include "planner/grasp/grasp_decision.hpp"

#include <catch2/catch.hpp>
#include <cmath>

namespace colift::planner {
namespace {

GraspCandidate at(int id, double x, double y, double z) {
  GraspCandidate c;
  c.id = id;
  c.position = Vec3(x, y, z);
  c.approach = -Vec3::UnitX();
  c.closing = Vec3::UnitZ();
  c.width = 0.025;
  return c;
}

// a table: partner at its left end, centre of gravity in the middle, height 0.7 m
DecisionInput table() {
  DecisionInput in;
  in.partner.position = Vec3(-0.4, 0, 0.7);
  in.cog = Vec3(0, 0, 0.7);
  return in;
}

Decision decided(std::vector<GraspCandidate>& candidates, const DecisionInput& in,
                 const DecisionConfig& config = {}) {
  auto d = decide_grasp(candidates, in, config);
  REQUIRE(d);
  return *d;
}

}  // namespace

TEST_CASE("the grasp opposite the partner is chosen and takes half the load", "[decision]") {
  std::vector<GraspCandidate> c{at(0, 0.4, -0.2, 0.7), at(1, 0.4, 0.0, 0.7), at(2, 0.4, 0.2, 0.7),
                                at(3, 0.2, 0.0, 0.7)};
  const Decision d = decided(c, table());
  REQUIRE(d.chosen);
  CHECK(c[*d.chosen].id == 1);
  CHECK(c[1].verdict == Verdict::Chosen);
  CHECK(d.share == Approx(0.5).epsilon(1e-9));
  CHECK((d.optimum - Vec3(0.4, 0, 0.7)).norm() < 1e-12);
  CHECK(d.reason.find("50 %") != std::string::npos);
  for (std::size_t i = 0; i < c.size(); ++i) CHECK(d.scores[i]->cost >= d.cost);
}

TEST_CASE("a wanted share moves the best place", "[decision]") {
  DecisionConfig config;
  config.weights.epsilon = *epsilon_for_share(2.0 / 3.0);
  std::vector<GraspCandidate> c{at(0, 0.4, 0, 0.7), at(1, 0.2, 0, 0.7)};
  const Decision d = decided(c, table(), config);
  REQUIRE(d.chosen);
  CHECK(c[*d.chosen].id == 1);
  CHECK(d.share == Approx(2.0 / 3.0).epsilon(1e-9));
}

TEST_CASE("a place far off the line through the partner and the centre of gravity would tip the object",
          "[decision]") {
  DecisionConfig config;
  config.max_lever_m = 0.1;
  // lines at 26.6 and 12.9 degrees to the one through the centre: 0.4 m * sine beside it
  std::vector<GraspCandidate> c{at(0, 0.2, 0.3, 0.7), at(1, 0.3, 0.16, 0.7)};
  const Decision d = decided(c, table(), config);
  REQUIRE(d.chosen);
  CHECK(c[*d.chosen].id == 1);
  CHECK(c[0].verdict == Verdict::Unstable);
  CHECK(c[0].reason.find("179 mm beside the line") != std::string::npos);
  c = {at(0, 0.2, 0.3, 0.7)};
  CHECK_FALSE(decided(c, table(), config).chosen);
}

TEST_CASE("a refusal says when the best place is out of reach altogether", "[decision]") {
  DecisionInput in = table();
  in.base_frame_known = true;
  in.cog = Vec3(0.6, 0, 0.7);
  in.partner.position = Vec3(0.2, 0, 0.7);
  DecisionConfig config;
  config.max_lever_m = 0.1;
  std::vector<GraspCandidate> c{at(0, 0.35, 0.3, 0.7)};
  CHECK(decided(c, in).reason.find("at (1.00, 0.00) m") == std::string::npos);
  c = {at(0, 0.35, 0.3, 0.7)};
  CHECK(decided(c, in, config).reason.find("at (1.00, 0.00) m, the load would be shared best") !=
        std::string::npos);
}

TEST_CASE("a candidate at the partner's hand is refused with the distance", "[decision]") {
  std::vector<GraspCandidate> c{at(0, -0.35, 0.05, 0.7), at(1, 0.4, 0, 0.7)};
  decided(c, table());
  CHECK(c[0].verdict == Verdict::NearPartner);
  CHECK(c[0].reason.find("71 mm") != std::string::npos);
}

TEST_CASE("hands at different heights may not balance the tilt by pushing", "[decision]") {
  // the foot of a leg, half a metre lower and beside the line: cheap on paper, pushing in practice
  std::vector<GraspCandidate> c{at(0, 0.05, 0.25, 0.05), at(1, 0.4, 0.1, 0.7)};
  const Decision d = decided(c, table());
  CHECK(c[0].verdict == Verdict::OverLimit);
  CHECK(c[0].reason.find("push sideways") != std::string::npos);
  REQUIRE(d.chosen);
  CHECK(c[*d.chosen].id == 1);
}

TEST_CASE("reach is judged only when the base is known", "[decision]") {
  DecisionInput in = table();
  std::vector<GraspCandidate> c{at(0, 0.4, 0, 0.7)};
  in.partner.position.x() = -2.0;
  in.cog.x() = -0.8;
  decided(c, in);
  CHECK(c[0].verdict == Verdict::Chosen);

  in.base_frame_known = true;
  std::vector<GraspCandidate> far{at(0, 1.4, 0, 0.7)};
  const Decision d = decided(far, in);
  CHECK(far[0].verdict == Verdict::Unreachable);
  CHECK_FALSE(d.chosen);
  CHECK(d.reason.find("out of the arm's reach") != std::string::npos);
}

TEST_CASE("limits of either agent refuse with what is missing", "[decision]") {
  DecisionConfig config;
  config.mass_kg = 8.0;
  config.limits.partner.force_n = 30.0;
  config.limits.robot.force_n = 30.0;
  std::vector<GraspCandidate> c{at(0, 0.4, 0, 0.7)};
  const Decision d = decided(c, table(), config);
  CHECK(c[0].verdict == Verdict::OverLimit);
  CHECK(c[0].reason.find("60 N") != std::string::npos);
  CHECK_FALSE(d.chosen);
  CHECK(d.scores[0]);
}

TEST_CASE("refusals of earlier stages stay, and none left says how many fell to what", "[decision]") {
  std::vector<GraspCandidate> c{at(0, 0.4, 0, 0.7), at(1, 0.3, 0, 0.7), at(2, -0.4, 0.0, 0.7)};
  c[0].verdict = c[1].verdict = Verdict::Collision;
  c[0].reason = c[1].reason = "finger 1 meets the ground 3 mm deep";
  const Decision d = decided(c, table());
  CHECK_FALSE(d.chosen);
  CHECK(c[0].verdict == Verdict::Collision);
  CHECK(d.reason.find("2 would meet the ground (candidate 0: finger 1 meets the ground 3 mm deep)") !=
        std::string::npos);
  CHECK(d.reason.find("1 too near the partner") != std::string::npos);
}

TEST_CASE("no candidates is said in words", "[decision]") {
  std::vector<GraspCandidate> none;
  CHECK(decided(none, table()).reason == "no grasp: the object offers no candidate");
}

TEST_CASE("the choice does not depend on the mass without limits", "[decision]") {
  std::vector<GraspCandidate> a{at(0, 0.35, 0.1, 0.7), at(1, 0.4, -0.2, 0.7)}, b = a;
  DecisionConfig heavy;
  heavy.mass_kg = 25.0;
  CHECK(decided(a, table()).chosen == decided(b, table(), heavy).chosen);
}

TEST_CASE("unusable weights are a configuration error", "[decision]") {
  DecisionConfig config;
  config.weights.epsilon = 0.0;
  std::vector<GraspCandidate> c{at(0, 0.4, 0, 0.7)};
  CHECK_FALSE(decide_grasp(c, table(), config));
}

}  // namespace colift::planner
