// What a lift of a few millimetres tells, tried on a table in static balance.

#include "control/test_lift/test_lift.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>

#include "table_in_balance.hpp"

using namespace colift;
using namespace colift::control;
using namespace colift::control::test;

namespace {

// along the near edge and half of both sides
std::vector<planner::GraspCandidate> grasps_around() {
  std::vector<planner::GraspCandidate> out;
  const auto add = [&](double x, double y) {
    planner::GraspCandidate c;
    c.position = {x, y, 0.4};
    out.push_back(c);
  };
  for (double y = -0.3; y <= 0.301; y += 0.02) add(-0.4, y);
  for (double x = -0.38; x <= 0.001; x += 0.02) add(x, -0.3), add(x, 0.3);
  return out;
}

}  // namespace

TEST_CASE("an even object is lifted on", "[test_lift]") {
  Table table;
  table.partner.y() = 0.0;
  MeasuredLift test = test_lift(table, {-0.4, 0.0, 0.4});
  const auto t = analyse_test_lift(seen(table), std::span(&test, 1), {});
  REQUIRE(t);
  CHECK(t->next == TestLift::Next::GoOn);
  CHECK_FALSE(t->stands);
  CHECK(t->mass_kg == Approx(4.0).epsilon(0.1));
  CHECK(t->share == Approx(0.5).epsilon(0.1));
  CHECK(t->lever_m < 0.005);
  CHECK(t->seen.tilt_rad < 1e-6);
  CarriedObject object = seen(table);
  SECTION("one that turns in the hand is put down") {
    test.drift_rad_s = 0.5 * kDegree;
    const auto slips = analyse_test_lift(object, std::span(&test, 1), {});
    REQUIRE(slips);
    CHECK(slips->next == TestLift::Next::Regrasp);
  }
  // feet are clear after a few millimetres
  CHECK(t->seen.min_rise_m < 0.005);
  SECTION("but borne otherwise than agreed, that is said") {
    test.share_predicted = 0.3;
    const auto other = analyse_test_lift(seen(table), std::span(&test, 1), {});
    REQUIRE(other);
    CHECK(other->next == TestLift::Next::OtherShare);
  }
}

TEST_CASE("a table that hangs tells the direction of its centre of gravity", "[test_lift]") {
  Table table;
  table.cog = {-0.05, 0.12, 0.3};
  table.grip_nm_rad = 400.0;
  MeasuredLift test = test_lift(table, {-0.4, 0.0, 0.4});
  CarriedObject object = seen(table);
  const auto t = analyse_test_lift(object, std::span(&test, 1), {});
  REQUIRE(t);
  CHECK_FALSE(t->stands);
  CHECK(t->next != TestLift::Next::Regrasp);  // it turns by less than a degree
  const Eigen::Vector2d a = (t->cog - kPartner).head<2>().normalized(),
                        b = (table.cog - kPartner).head<2>().normalized();
  CHECK((a - b).norm() < 0.01);
  CHECK(t->belief.grip_nm_rad == Approx(400.0).epsilon(0.4));
  SECTION("mass and distance are one number, unless one is known") {
    object.known_mass_kg = 4.0;
    const auto known = analyse_test_lift(object, std::span(&test, 1), {});
    REQUIRE(known);
    CHECK(known->mass_kg == Approx(4.0).epsilon(1e-6));
    CHECK((known->cog - table.cog).head<2>().norm() < 0.03);
    // 4 kg feel like 2.5 kg farther away
    object.known_mass_kg = 2.5;
    const auto lighter = analyse_test_lift(object, std::span(&test, 1), {});
    REQUIRE(lighter);
    CHECK((lighter->cog - kPartner).norm() > (known->cog - kPartner).norm() + 0.05);
  }
}

TEST_CASE("two places of the partner tell mass and distance apart", "[test_lift]") {
  Table table;
  table.cog = {-0.08, 0.13, 0.3};
  table.grip_nm_rad = 400.0;
  std::vector<MeasuredLift> tests{test_lift(table, {-0.4, 0.0, 0.4})};
  const auto one = analyse_test_lift(seen(table), tests, {});
  REQUIRE(one);
  table.partner = {0.1, -0.3, 0.4};
  tests.push_back(test_lift(table, {-0.4, 0.25, 0.4}));
  const auto two = analyse_test_lift(seen(table), tests, {});
  REQUIRE(two);
  const auto along_sigma = [&](const CogBelief& belief) {
    const Eigen::Vector2d ray = (table.cog - kPartner).head<2>().normalized();
    return std::sqrt(ray.dot(belief.covariance() * ray));
  };
  CHECK(along_sigma(one->belief) > 0.06);
  CHECK(along_sigma(two->belief) < 0.02);
  CHECK((two->cog - table.cog).head<2>().norm() < 0.02);
  CHECK(two->mass_kg == Approx(4.0).epsilon(0.1));
}

TEST_CASE("what hangs at more than is good is kept for want of better", "[test_lift]") {
  Table table;
  table.cog = {0.0, 0.10, 0.3};
  for (const auto& [turn_deg, bearable] : {std::pair{1.6, true}, {1.9, false}}) {
    const double lever = 0.10 - 0.025;  // of the line from (0.4, 0.05) to (-0.4, 0)
    table.grip_nm_rad = table.mass_kg * kGravity * lever / (turn_deg * kDegree);
    const MeasuredLift test = raised(table, {-0.4, 0.0, 0.4}, 0.03);
    const auto t = analyse_test_lift(seen(table), std::span(&test, 1), {});
    REQUIRE(t);
    CHECK_FALSE(t->stands);
    CHECK(t->next == TestLift::Next::Regrasp);
    CHECK(t->bearable == bearable);
  }
}

TEST_CASE("a foot that stands hides the lever, and tells the side", "[test_lift]") {
  Table table;
  for (const double y : {-0.17, 0.17}) {
    table.cog = {-0.05, y, 0.3};
    const MeasuredLift test = test_lift(table, {-0.4, 0.0, 0.4});
    const auto t = analyse_test_lift(seen(table), std::span(&test, 1), {});
    REQUIRE(t);
    CHECK(t->stands);
    CHECK(t->next == TestLift::Next::Regrasp);
    // never turned further than it may
    CHECK(t->seen.tilt_rad < 2.0 * kDegree);
    const Eigen::Vector2d measured = control::measured_moment(test);
    const auto lever = [](const Eigen::Vector2d& arm) {
      const Eigen::Vector2d line = Eigen::Vector2d(-0.8, -0.05).normalized();
      return line.x() * arm.y() - line.y() * arm.x();
    };
    const double believed = lever((t->cog - kPartner).head<2>()),
                 truly = lever((table.cog - kPartner).head<2>());
    CHECK(believed * truly > 0.0);
    CHECK(std::abs(believed) > 0.4 * std::abs(truly));
    CHECK(std::abs(lever(measured / table.mass_kg)) < 0.4 * std::abs(truly));
  }
}

TEST_CASE("test lifts at several grasps find a level one", "[test_lift]") {
  const control::TestLiftConfig config;
  const auto grasps = grasps_around();
  int bad = 0, possible = 0, found = 0, wrong = 0;
  for (const double mass : {2.0, 4.0, 6.0}) {
    for (const double off : {0.10, 0.15, 0.20}) {
      for (int k = 0; k < 16; ++k) {
        const double a = (k + 0.5) * std::numbers::pi / 8.0;
        Table table;
        table.mass_kg = mass;
        table.cog += Vec3(off * std::cos(a), off * std::sin(a), 0.0);
        Vec3 grasp(-0.4, -0.04, 0.4);
        if (tilt_deg(table, grasp) <= 2.0) continue;
        ++bad;
        possible += std::any_of(grasps.begin(), grasps.end(),
                                [&](const auto& c) { return tilt_deg(table, c.position) < 1.5; });
        std::vector<MeasuredLift> tests;
        while (static_cast<int>(tests.size()) < config.grips) {
          tests.push_back(test_lift(table, grasp, config));
          const auto t = analyse_test_lift(seen(table), tests, config);
          if (!t) break;  // the robot bears nothing
          CHECK(t->seen.tilt_rad < 2.0 * kDegree);
          if (t->next != TestLift::Next::Regrasp) {
            ++found;
            wrong += tilt_deg(table, grasp) > 2.0;
            break;
          }
          const auto next = next_grip(grasps, table.partner, tests, t->belief, 0.5, config);
          if (!next) break;
          grasp = grasps[next->index].position;
        }
      }
    }
  }
  INFO("of " << bad << " bad first grips " << possible << " had a level one, " << found << " were found");
  CHECK(bad > 80);
  CHECK(wrong == 0);
  CHECK(found >= 0.9 * possible);
}

TEST_CASE("the next grip is one that is possible and was not tried", "[test_lift]") {
  Table table;
  table.cog = {0.0, 0.15, 0.3};
  const MeasuredLift test = test_lift(table, {-0.4, 0.0, 0.4});
  const std::span tests(&test, 1);
  const auto t = analyse_test_lift(seen(table), tests, {});
  REQUIRE(t);
  auto grasps = grasps_around();
  const auto next = next_grip(grasps, table.partner, tests, t->belief, 0.5, {});
  REQUIRE(next);
  CHECK(grasps[next->index].position.y() > 0.05);
  CHECK(next->chance > 0.05);
  grasps[next->index].verdict = planner::Verdict::Collision;
  const auto other = next_grip(grasps, table.partner, tests, t->belief, 0.5, {});
  REQUIRE(other);
  CHECK(other->index != next->index);
  // what was tried while the partner held elsewhere is no longer tried
  grasps[next->index].verdict = planner::Verdict::Ok;
  const Vec3 on_line = table.cog + 1.5 * (table.cog - Vec3(-0.4, 0.0, 0.4));
  const auto again = next_grip(grasps, on_line, tests, t->belief, 0.5, {});
  REQUIRE(again);
  std::vector<MeasuredLift> there{test};
  there.back().partner = on_line;
  there.back().grasp = grasps[again->index].position;
  const auto different = next_grip(grasps, on_line, there, t->belief, 0.5, {});
  REQUIRE(different);
  CHECK(different->index != again->index);
  there.back().partner = table.partner;
  CHECK(next_grip(grasps, on_line, there, t->belief, 0.5, {})->index == again->index);
  grasps[next->index].verdict = planner::Verdict::Collision;
  // a chance of nothing is none
  for (auto& c : grasps)
    if (c.position.y() > -0.25) c.verdict = planner::Verdict::Unreachable;
  CHECK_FALSE(next_grip(grasps, table.partner, tests, t->belief, 0.5, {}));
}

TEST_CASE("a test lift that says nothing is refused", "[test_lift]") {
  const Table table;
  MeasuredLift test = test_lift(table, {-0.4, 0.0, 0.4});
  const CarriedObject object = seen(table);
  const auto code = [](const CarriedObject& o, const MeasuredLift& f) {
    const auto t = analyse_test_lift(o, std::span(&f, 1), {});
    return t ? hal::ErrorCode{} : t.error().code;
  };
  CHECK(analyse_test_lift(object, {}, {}).error().code == hal::ErrorCode::BadInput);
  MeasuredLift none = test;
  none.measured = {};
  CHECK(code(object, none) == hal::ErrorCode::NotFound);
  none.measured.force.x() = NAN;
  CHECK(code(object, none) == hal::ErrorCode::BadInput);
  // it has not moved at all
  MeasuredLift still = test;
  still.X_WTnow_WTref = hal::Pose::Identity();
  CHECK(code(object, still) == hal::ErrorCode::NotFound);
  // after one that told something it is a grip that slides, and tells nothing more
  none = still;
  const std::vector<MeasuredLift> both{test, none};
  const auto before = analyse_test_lift(object, std::span(&test, 1), {});
  const auto slides = analyse_test_lift(object, both, {});
  REQUIRE(before);
  REQUIRE(slides);
  CHECK(slides->next == TestLift::Next::Regrasp);
  CHECK_THAT(slides->reason, Catch::Contains("slides"));
  CHECK((slides->cog - before->cog).norm() < 1e-9);
  MeasuredLift near = test;
  near.grasp = kPartner + Vec3(0.02, 0.0, 0.0);
  CHECK(code(object, near) == hal::ErrorCode::BadInput);
  CarriedObject flat = object;
  flat.feet.resize(2);
  CHECK(code(flat, test) == hal::ErrorCode::BadInput);
}
