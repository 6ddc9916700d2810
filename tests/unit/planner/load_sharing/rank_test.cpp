#include "planner/load_sharing/rank.hpp"

#include <catch2/catch.hpp>

#include <limits>

#include "reference.hpp"

using namespace colift::planner;
using reference::Dice;

namespace {

RankProblem example() {
  RankProblem p;
  p.partner = {-0.4, 0, 0};
  p.candidates = {{0.4, 0, 0}, {0.2, 0, 0}};
  p.wrenches = {{{0, 0, 40}, Vec3::Zero()}};
  p.weights = SharingWeights::thesis();
  return p;
}

}  // namespace

TEST_CASE("the cheaper grasp comes first", "[rank]") {
  const auto r = rank(example()).value();
  CHECK(r.best == 0u);
  REQUIRE(r.ranking.size() == 2);
  CHECK(r.ranking[0].cost == Approx(800).epsilon(1e-14));
  CHECK(r.ranking[0].share.value() == Approx(0.5).epsilon(1e-14));
  CHECK(r.ranking[1].candidate == 1);
  CHECK(r.ranking[1].cost > 800);
}

TEST_CASE("a candidate beyond the limits comes last and says why", "[rank]") {
  RankProblem p = example();
  p.candidates = {{-0.6, 0, 0}, {0.4, 0, 0}};
  p.limits = SharingLimits{{30, 1}, {30, 1}};
  const auto r = rank(p).value();
  CHECK(r.best == 1u);
  CHECK(r.ranking[1].candidate == 0);
  CHECK_FALSE(r.ranking[1].feasible);
  CHECK(std::isnan(r.ranking[1].cost));
  CHECK(r.ranking[1].poses.empty());
  CHECK(r.ranking[1].reason.find("N m about") != std::string::npos);

  p.limits = SharingLimits{{15, 1}, {20, 1}};
  const auto none = rank(p).value();
  CHECK_FALSE(none.best);
  CHECK(none.ranking[0].candidate == 0);
  CHECK(none.ranking[0].reason == "needs 40 N along z; partner 15 N and robot 20 N give 35 N");
}

TEST_CASE("one impossible pose is enough, and it is named", "[rank]") {
  RankProblem p = example();
  p.limits = SharingLimits{{25, 5}, {25, 5}};
  p.wrenches.push_back({{60, 0, 0}, Vec3::Zero()});
  const auto r = rank(p).value();
  CHECK_FALSE(r.best);
  CHECK(r.ranking[0].reason == "pose 1: needs 60 N along x; partner 25 N and robot 25 N give 50 N");
}

TEST_CASE("equal candidates keep their order", "[rank]") {
  RankProblem p = example();
  p.candidates.assign(50, Vec3(0.4, 0.1, 0));
  p.candidates[17] = {0.4, 0, 0};
  const auto r = rank(p).value();
  CHECK(r.best == 17u);
  for (std::size_t i = 2; i < 50; ++i) CHECK(r.ranking[i - 1].candidate < r.ranking[i].candidate);
}

TEST_CASE("moving everything together changes no digit that matters", "[rank]") {
  Dice dice(21);
  for (int i = 0; i < 100; ++i) {
    RankProblem p;
    p.weights = {dice.log_uniform(0.3, 3), dice.log_uniform(0.5, 30), dice.log_uniform(0.5, 30)};
    p.partner = dice.vector(1);
    for (int k = 0; k < 5; ++k) p.candidates.push_back(dice.vector(1));
    p.wrenches = {dice.wrench(50, 5), dice.wrench(50, 5)};
    if (i % 2) p.limits = SharingLimits{{40, 6}, {40, 6}};
    RankProblem moved = p;
    const Vec3 shift = dice.vector(3);
    moved.cog += shift;
    moved.partner += shift;
    for (Vec3& c : moved.candidates) c += shift;
    const auto a = rank(p).value(), b = rank(moved).value();
    CHECK(a.best == b.best);
    for (std::size_t k = 0; k < a.ranking.size(); ++k) {
      CHECK(a.ranking[k].candidate == b.ranking[k].candidate);
      if (a.ranking[k].feasible) CHECK(a.ranking[k].cost == Approx(b.ranking[k].cost).epsilon(1e-9));
    }
  }
}

TEST_CASE("the share is counted along the task force over all poses", "[rank]") {
  RankProblem p = example();
  p.weights.epsilon = epsilon_for_share(0.75).value();
  p.candidates = {{0.4 / 3, 0, 0}};
  p.wrenches = {{{0, 0, 40}, Vec3::Zero()}, {{0, 0, -10}, Vec3::Zero()}, {Vec3::Zero(), {0, 0, 3}}};
  CHECK(rank(p)->ranking[0].share.value() == Approx(0.75).epsilon(1e-13));
  p.wrenches = {{Vec3::Zero(), {0, 0, 3}}};
  CHECK_FALSE(rank(p)->ranking[0].share);
  p.wrenches = {{Vec3::Zero(), Vec3::Zero()}};
  CHECK(rank(p)->ranking[0].cost == 0.0);
}

TEST_CASE("a problem that cannot be ranked is refused with its place", "[rank]") {
  const auto refused = [](auto change) {
    RankProblem p = example();
    change(p);
    const auto r = rank(p);
    REQUIRE_FALSE(r);
    CHECK(r.error().code == colift::hal::ErrorCode::BadInput);
    return r.error().where;
  };
  CHECK(refused([](RankProblem& p) { p.candidates.clear(); }) == "candidates");
  CHECK(refused([](RankProblem& p) { p.wrenches.clear(); }) == "wrenches");
  CHECK(refused([](RankProblem& p) { p.candidates[1].y() = std::nan(""); }) == "candidates[1][1]");
  CHECK(refused([](RankProblem& p) { p.weights.epsilon = 0; }) == "weights.epsilon");
  CHECK(refused([](RankProblem& p) { p.limits = SharingLimits{{-1, 1}, {1, 1}}; }) == "limits.partner.force");
  CHECK(refused([](RankProblem& p) { p.wrenches[0].force.z() = 1e200; }) == "candidates[0]");
}
