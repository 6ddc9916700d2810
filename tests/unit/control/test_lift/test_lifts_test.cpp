#include "control/test_lift/test_lifts.hpp"

#include <catch2/catch.hpp>
#include <chrono>
#include <numbers>

#include "control/test_lift/level_grip.hpp"
#include "hal/types/units.hpp"

using namespace colift;
using namespace std::chrono_literals;
using control::Raise;
using control::TestLifts;
using hal::Vec3;

namespace {

const Vec3 kPartner(0.4, 0.0, 0.4), kGrasp(-0.4, 0.0, 0.4);

control::CarriedObject table() {
  control::CarriedObject object;
  object.cog = {0.0, 0.0, 0.3};
  object.cog_covariance = 1e-4 * Eigen::Matrix3d::Identity();
  object.feet = {{-0.4, -0.3, 0.0}, {0.4, -0.3, 0.0}, {0.4, 0.3, 0.0}, {-0.4, 0.3, 0.0}};
  return object;
}

perception::ObjectMotion raised(double height_m, double turn_rad = 0.0) {
  perception::ObjectMotion motion;
  motion.X_WTnow_WTref = Eigen::Translation3d(0.0, 0.0, height_m) * Eigen::Translation3d(kPartner) *
                         Eigen::AngleAxisd(turn_rad, (kGrasp - kPartner).normalized()) *
                         Eigen::Translation3d(-kPartner);
  return motion;
}

/// A table of 4 kg whose centre of gravity lies a little to one side: both hands hold it with 65 N m/rad.
void lift(TestLifts& lifts, double cog_y) {
  const Vec3 u = (kGrasp - kPartner).normalized();
  const double turn = -4.0 * hal::kGravity_m_s2 * Vec3::UnitZ().cross(u).dot(Vec3(0.0, cog_y, 0.0)) / 65.0;
  lifts.begin(table(), kPartner, kGrasp, 0.5);
  for (int i = 0; i < 10; ++i) (void)lifts.rising(raised(0.02, turn));
  for (int i = 0; i < 30; ++i) {
    lifts.at_top(33ms * i, raised(0.02, turn));
    lifts.feel({Vec3(0.0, 0.0, -0.5 * 4.0 * hal::kGravity_m_s2), 65.0 * turn * u}, kGrasp);
  }
}

}  // namespace

TEST_CASE("a test lift that is watched to its end tells mass and centre of gravity", "[test_lifts]") {
  TestLifts lifts({});
  CHECK(lifts.said() == Raise::On);
  lift(lifts, 0.03);
  CHECK(lifts.said() == Raise::Enough);
  const auto known = lifts.end();
  REQUIRE(known);
  CHECK(lifts.measured().size() == 1);
  CHECK(known->mass_kg == Approx(4.0).epsilon(0.15));
  CHECK(known->cog.y() == Approx(0.03).margin(0.01));
  REQUIRE(lifts.known());
  CHECK(lifts.known()->cog == known->cog);
}

TEST_CASE("one frame does not end a test lift: the object swings", "[test_lifts]") {
  TestLifts lifts({});
  lifts.begin(table(), kPartner, kGrasp, 0.5);
  CHECK(lifts.rising(raised(0.02)) == Raise::On);
  CHECK(lifts.rising(raised(0.0005)) == Raise::On);
  CHECK(lifts.rising(raised(0.02)) == Raise::On);
}

TEST_CASE("without a picture or without a feeling at the top nothing is known", "[test_lifts]") {
  TestLifts lifts({});
  lifts.begin(table(), kPartner, kGrasp, 0.5);
  lifts.feel({Vec3(0.0, 0.0, -20.0), Vec3::Zero()}, kGrasp);
  REQUIRE_FALSE(lifts.end());
  lifts.begin(table(), kPartner, kGrasp, 0.5);
  lifts.at_top(0ms, raised(0.02));
  REQUIRE_FALSE(lifts.end());
  CHECK(lifts.measured().empty());
  CHECK_FALSE(lifts.known());
}

TEST_CASE("a test lift that says nothing leaves what was known", "[test_lifts]") {
  TestLifts lifts({});
  lift(lifts, 0.03);
  const auto known = lifts.end();
  REQUIRE(known);
  lifts.begin(table(), kPartner, kGrasp, 0.5);
  lifts.at_top(0ms, raised(0.02));
  lifts.feel({Vec3::Zero(), Vec3::Zero()}, kGrasp);  // bears nothing: it stands
  REQUIRE_FALSE(lifts.end());
  CHECK(lifts.measured().size() == 1);
  CHECK(lifts.known()->cog == known->cog);
}

TEST_CASE("what was felt goes with an object that was put down elsewhere", "[test_lifts]") {
  const hal::Pose X = Eigen::Translation3d(0.02, -0.01, 0.0) * Eigen::AngleAxisd(0.03, Vec3::UnitZ());
  TestLifts lifts({});
  lift(lifts, 0.03);
  const auto before = lifts.end();
  REQUIRE(before);
  lifts.move(X);
  CHECK((lifts.known()->cog - X * before->cog).norm() < 1e-9);
  // weighed anew there, the same centre of gravity comes out
  const auto after = analyse_test_lift(lifts.object(), lifts.measured(), {});
  REQUIRE(after);
  CHECK((after->cog - X * before->cog).norm() < 0.005);
  CHECK(after->mass_kg == Approx(before->mass_kg).epsilon(0.02));
  CHECK(after->seen.tilt_rad == Approx(before->seen.tilt_rad).margin(1e-6));
}

TEST_CASE("the grasp that is chosen after test lifts lies where the object is heavy", "[test_lifts]") {
  TestLifts lifts({});
  lift(lifts, 0.02);
  const auto known = lifts.end();
  REQUIRE(known);
  const auto decide = [&](const Vec3& cog) -> hal::Result<control::Outcome> {
    control::Outcome outcome;
    for (double y = -0.2; y <= 0.201; y += 0.02) {
      planner::GraspCandidate c;
      c.id = static_cast<int>(outcome.candidates.size());
      c.position = {-0.4, y, 0.4};
      outcome.candidates.push_back(c);
    }
    outcome.decision.chosen = 0;
    outcome.candidates[0].verdict = planner::Verdict::Chosen;
    outcome.decision.scores.resize(outcome.candidates.size());
    outcome.decision.optimum = cog;
    return outcome;
  };
  const auto grip =
      choose_level_grip(decide, lifts.object(), kPartner, lifts.measured(), known->belief, 0.5, {});
  REQUIRE(grip);
  const planner::Decision& decision = grip->outcome.decision;
  REQUIRE(decision.chosen);
  const planner::GraspCandidate& chosen = grip->outcome.candidates[*decision.chosen];
  // beyond the centre of gravity as seen from the partner, so about twice as far aside
  CHECK(chosen.position.y() == Approx(0.04).margin(0.03));
  CHECK(grip->chance > 0.5);
  int marked = 0;
  for (const auto& c : grip->outcome.candidates) marked += c.verdict == planner::Verdict::Chosen;
  CHECK(marked == 1);
  CHECK(decision.reason.find("level") != std::string::npos);

  const auto none = [](const Vec3&) -> hal::Result<control::Outcome> { return control::Outcome{}; };
  CHECK_FALSE(choose_level_grip(none, lifts.object(), kPartner, lifts.measured(), known->belief, 0.5, {}));
}
