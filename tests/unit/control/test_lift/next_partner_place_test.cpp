// Where the partner is asked to take hold, tried on a table in static balance of which the robot reaches the
// near end only.

#include "control/test_lift/partner_request.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <random>

#include "table_in_balance.hpp"

using namespace colift;
using namespace colift::control;
using namespace colift::control::test;

namespace {

std::vector<planner::GraspCandidate> rim() {
  std::vector<planner::GraspCandidate> out;
  const auto add = [&](double x, double y) {
    planner::GraspCandidate c;
    c.position = {x, y, 0.4};
    if (x > -0.39 || std::abs(y) > 0.16) c.verdict = planner::Verdict::Unreachable;
    out.push_back(c);
  };
  for (double y = -0.3; y <= 0.301; y += 0.05) add(-0.4, y), add(0.4, y);
  for (double x = -0.35; x <= 0.351; x += 0.05) add(x, -0.3), add(x, 0.3);
  return out;
}

CogBelief learnt(const Table& table, std::vector<MeasuredLift>& tests) {
  tests.push_back(test_lift(table, {-0.4, 0.0, 0.4}));
  const auto t = analyse_test_lift(seen(table), tests, {});
  REQUIRE(t);
  return t->belief;
}

}  // namespace

TEST_CASE("the partner is asked to go where the line through the centre of gravity leaves the table",
          "[next_partner_place]") {
  Table table;
  std::vector<MeasuredLift> tests;
  for (const double side : {-1.0, 1.0}) {
    table.cog = {-0.05, side * 0.17, 0.3};
    tests.clear();
    const CogBelief belief = learnt(table, tests);
    const auto place = next_partner_place(rim(), rim(), {&table.partner, 1}, belief, {});
    REQUIRE(place);
    CHECK(side * place->position.y() > 0.08);
    CHECK(place->chance > 0.5);
    CHECK(place->share > 0.15);
    CHECK(place->share < 0.85);
    CHECK(place->robot.x() == Approx(-0.4));  // the robot stays where it reaches
    // he faces the robot: y > 0 is on his right
    CHECK_THAT(place->reason, Catch::Contains(side > 0.0 ? "further right" : "further left"));
    CHECK_THAT(place->reason, Catch::Contains(fmt::format("({:.2f}, {:.2f}, 0.40)", place->position.x(),
                                                          place->position.y())));
  }
}

TEST_CASE("with what is learnt where the partner was sent a level grip is found", "[next_partner_place]") {
  const TestLiftConfig config;
  std::mt19937 random(1);
  const auto between = [&](double low, double high) {
    return std::uniform_real_distribution<>(low, high)(random);
  };
  int bad = 0, alone = 0, asked = 0, wrong = 0;
  for (int trial = 0; trial < 60; ++trial) {
    Table table;
    const double off = between(0.10, 0.20), a = between(-std::numbers::pi, std::numbers::pi);
    table.mass_kg = between(2.0, 6.0);
    table.cog += Vec3(off * std::cos(a), off * std::sin(a), 0.0);
    Vec3 grasp(-0.4, 0.0, 0.4);
    if (tilt_deg(table, grasp) <= 2.0) continue;
    ++bad;
    std::vector<MeasuredLift> tests;
    std::vector<Vec3> held{table.partner};
    std::optional<CogBelief> belief;
    bool level = false;
    for (int asks = 0; !level; ++asks) {
      for (int grip = 0; grip < config.grips && !level; ++grip) {
        if (!tests.empty()) {
          const auto next = next_grip(rim(), table.partner, tests, *belief, 0.5, config);
          if (!next) break;
          grasp = rim()[next->index].position;
        }
        tests.push_back(test_lift(table, grasp, config));
        const auto t = analyse_test_lift(seen(table), tests, config);
        REQUIRE(t);
        belief = t->belief;
        level = t->next != TestLift::Next::Regrasp;
      }
      if (level) {
        (asks ? asked : alone) += 1;
        wrong += tilt_deg(table, grasp) > 2.0;
      }
      if (level || asks == config.asks) break;
      const auto place = next_partner_place(rim(), rim(), held, *belief, config);
      if (!place) break;
      // not exactly where he was told
      table.partner = place->position + Vec3(0.0, between(-0.03, 0.03), 0.0);
      held.insert(held.begin(), table.partner);
    }
  }
  INFO("of " << bad << " bad first grips " << alone << " became level, " << asked << " when he was asked");
  CHECK(bad > 30);
  CHECK(wrong == 0);
  CHECK(alone < 0.8 * bad);
  CHECK(alone + asked >= 0.95 * bad);
}

TEST_CASE("a place in vain, one at the feet and one without a sensible share are not asked for",
          "[next_partner_place]") {
  Table table;
  table.cog = {-0.05, 0.17, 0.3};
  std::vector<MeasuredLift> tests;
  const CogBelief belief = learnt(table, tests);
  const auto first = next_partner_place(rim(), rim(), {&table.partner, 1}, belief, {});
  REQUIRE(first);
  const std::vector<Vec3> held{table.partner, first->position};
  const auto second = next_partner_place(rim(), rim(), held, belief, {});
  REQUIRE(second);
  CHECK((second->position - first->position).norm() >= 0.1);
  // all that a hand can grip stands at the feet
  auto low = rim();
  for (auto& c : low) c.position.z() = 0.05;
  CHECK_FALSE(next_partner_place(low, rim(), {&table.partner, 1}, belief, {}));
  TestLiftConfig all_ours;
  all_ours.min_share = 0.99;
  CHECK_FALSE(next_partner_place(rim(), rim(), {&table.partner, 1}, belief, all_ours));
  TestLiftConfig certain;
  certain.min_level_probability_elsewhere = 1.0;
  CHECK_FALSE(next_partner_place(rim(), rim(), {&table.partner, 1}, belief, certain));
}

TEST_CASE("nobody is asked where the robot has no grasp or nothing is known", "[next_partner_place]") {
  Table table;
  table.cog = {-0.05, 0.17, 0.3};
  std::vector<MeasuredLift> tests;
  const CogBelief belief = learnt(table, tests);
  CHECK_FALSE(next_partner_place(rim(), {}, {&table.partner, 1}, belief, {}));
  CHECK_FALSE(next_partner_place({}, rim(), {&table.partner, 1}, belief, {}));
  CHECK_FALSE(next_partner_place(rim(), rim(), {}, belief, {}));
  CHECK_FALSE(next_partner_place(rim(), rim(), {&table.partner, 1}, CogBelief{}, {}));
}
