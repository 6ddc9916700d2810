#include "control/session/share_contract.hpp"

#include <catch2/catch.hpp>
#include <cmath>

#include "control/session/decide.hpp"
#include "hal/types/units.hpp"

using namespace colift;
using namespace colift::control;
using hal::Vec3;

namespace {

constexpr double kHigh_m = 0.5;

/// A table top, 0.8 m x 0.6 m; the robot reaches the end at x < 0. As completed and as seen, with a centre of
/// gravity that is known to `sigma_m`.
SceneAnalysis table(double sigma_m) {
  SceneAnalysis a;
  a.scene.ground.emplace();
  a.scene.ground->plane.normal = Vec3::UnitZ();
  perception::Target target;
  target.cog = Vec3(0.0, 0.0, kHigh_m);
  target.cog_covariance = sigma_m * sigma_m * Eigen::Matrix3d::Identity();
  target.shape.size = Vec3(0.8, 0.6, 0.03);
  target.shape.axes.setIdentity();
  a.scene.target = target;
  perception::Rectangle top;
  top.center = target.cog;
  top.size = {0.8, 0.6};
  a.scene.surfaces.emplace_back(top);
  for (double y = -0.3; y < 0.31; y += 0.1) {
    planner::GraspCandidate c;
    c.id = static_cast<int>(a.candidates.size());
    c.position = Vec3(-0.4, y, kHigh_m);
    a.candidates.push_back(c);
  }
  return a;
}

Config config_with(std::optional<double> share) {
  Config config;
  config.candidates.refine_lines = config.candidates.refine_steps = 0;
  config.decision.unevenness = 0.0;
  config.certificate.share_below = config.certificate.share_above = 1.96;
  config.decision.max_lever_m = 0.065;
  config.decision.share = share;
  if (share) config.decision.weights.epsilon = *planner::epsilon_for_share(*share);
  return config;
}

perception::PartnerGrasp hand_at(const Vec3& place) {
  perception::PartnerGrasp grasp;
  grasp.position = place;
  return grasp;
}

Outcome decided(const SceneAnalysis& analysis, const Config& config, const Vec3& partner,
                std::optional<double> mass_kg = {}) {
  const hal::ManualClock clock;
  auto outcome = decide_for(analysis, hand_at(partner), config, clock, {}, mass_kg);
  REQUIRE(outcome);
  return *std::move(outcome);
}

const Vec3 kEnd(0.4, 0.0, kHigh_m);

}  // namespace

TEST_CASE("a share that levers do not permit is not called as wished, and the place for it is named",
          "[share]") {
  const SceneAnalysis analysis = table(0.005);
  const Outcome outcome = decided(analysis, config_with(0.3), kEnd);
  const ShareContract& share = outcome.share;
  REQUIRE((share.reachable && share.predicted && share.as_wished));
  CHECK(share.reachable->low == Approx(0.5).margin(0.02));
  CHECK_FALSE(*share.as_wished);
  CHECK_THAT(share.text, Catch::Contains("30 % asked") && Catch::Contains("off what was asked"));
  CHECK_THAT(share.text, !Catch::Contains("as wished"));
  CHECK_THAT(outcome.decision.reason, Catch::Contains(share.text));
  // nothing of a table's rim lies 17 cm beyond its middle but at the sides, where it would tip
  CHECK_FALSE(share.elsewhere);
  CHECK_THAT(share.text, Catch::Contains("no place of the partner was found"));
}

TEST_CASE("the place that is named gives the wanted share", "[share]") {
  SceneAnalysis analysis = table(0.005);
  perception::Rectangle shelf;  // an edge across the table, where a hand can go
  shelf.center = Vec3(0.2, 0.0, kHigh_m);
  shelf.size = {0.06, 0.6};
  analysis.scene.surfaces.emplace_back(shelf);
  const Outcome outcome = decided(analysis, config_with(0.3), kEnd);
  REQUIRE(outcome.share.elsewhere);
  CHECK(outcome.share.elsewhere->share == Approx(0.3).margin(0.02));
  const Outcome there = decided(analysis, config_with(0.3), outcome.share.elsewhere->partner);
  REQUIRE(there.share.as_wished);
  CHECK(*there.share.as_wished);
  CHECK(there.decision.share == Approx(0.3).margin(0.02));
  CHECK_THAT(there.share.text, Catch::Contains("as wished to within"));
  CHECK_FALSE(there.share.elsewhere);
}

TEST_CASE("the interval is the uncertainty of the lever, and too wide a one makes no promise", "[share]") {
  const Outcome sure = decided(table(0.01), config_with(0.5), kEnd);
  REQUIRE((sure.share.interval && sure.share.as_wished));
  // 10 mm on a line of 0.8 m; and 1 N m of hands that resist a tilt, of 4 kg on it
  const double grip = 1.0 / (4.0 * 9.80665 * 0.8);
  CHECK(sure.share.interval->high - sure.share.interval->low ==
        Approx(2 * 1.96 * std::hypot(0.0125, grip)).epsilon(0.02));
  CHECK(*sure.share.as_wished);
  const Outcome vague = decided(table(0.10), config_with(0.5), kEnd);
  CHECK_FALSE(*vague.share.as_wished);
  CHECK_THAT(vague.share.text, Catch::Contains("not certain enough"));
}

TEST_CASE("without a wanted share the reason stays, and the range is there all the same", "[share]") {
  const Outcome outcome = decided(table(0.01), config_with({}), kEnd);
  REQUIRE(outcome.share.reachable);
  CHECK_FALSE(outcome.share.wanted);
  CHECK_FALSE(outcome.share.as_wished);
  CHECK_FALSE(outcome.share.elsewhere);
  CHECK_THAT(outcome.decision.reason, !Catch::Contains("predicted"));
}

TEST_CASE("the partner's load is unknown without a mass, and said to be", "[share]") {
  const Outcome unknown = decided(table(0.01), config_with({}), kEnd);
  CHECK_FALSE(unknown.share.partner_load_n);
  CHECK(*unknown.share.partner_limit_n == 245.0);
  CHECK_THAT(unknown.share.partner_text, Catch::Contains("not known before the lift"));
  const Outcome known = decided(table(0.01), config_with({}), kEnd, 10.0);
  CHECK(*known.share.partner_load_n == Approx(0.5 * 10.0 * hal::kGravity_m_s2));
  const Outcome heavy = decided(table(0.01), config_with({}), kEnd, 60.0);
  CHECK_FALSE(heavy.decision.chosen);
  CHECK_THAT(heavy.decision.reason, Catch::Contains("of 60.0 kg (limit 245 N)"));
}

TEST_CASE("a strict share is refused with the figures and the possible range", "[share]") {
  Config config = config_with(0.3);
  config.decision.share_strict = 0.05;
  const Outcome outcome = decided(table(0.01), config, kEnd);
  CHECK_FALSE(outcome.decision.chosen);
  CHECK(outcome.decision.refused_for_share);
  CHECK_FALSE(outcome.share.predicted);
  CHECK_THAT(outcome.decision.reason,
             Catch::Contains("30 % of the load were wanted, the robot would carry 50 %") &&
                 Catch::Contains("limit 5.0 %") && Catch::Contains("possible"));
}

TEST_CASE("a lift whose bounds are beyond a limit is refused with the number, where that is asked for",
          "[share]") {
  Config config = config_with({});
  config.task.max_tilt_deg = 0.5;
  config.certificate.lead_m = 0.8 * std::tan(hal::deg_to_rad(1.0));
  config.certificate.turning = 0.0;
  config.certificate.tilt_factor = 2.0;
  config.certificate.on_breach = "report";
  const Outcome reported = decided(table(0.0), config, kEnd);
  REQUIRE((reported.decision.chosen && reported.share.certificate));
  CHECK_THAT(reported.share.certificate->breach_text, Catch::Contains("2.0 deg, 0.5 are allowed"));
  config.certificate.on_breach = "refuse";
  const Outcome refused = decided(table(0.0), config, kEnd);
  CHECK_FALSE(refused.decision.chosen);
  CHECK_THAT(refused.decision.reason, Catch::Contains("the tilt may reach 2.0 deg, 0.5 are allowed"));
}
