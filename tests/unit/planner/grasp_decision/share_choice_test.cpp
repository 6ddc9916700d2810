#include "planner/grasp/share_choice.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <vector>

namespace colift::planner {
namespace {

GraspCandidate at(int id, double x, double y) {
  GraspCandidate c;
  c.id = id;
  c.position = Vec3(x, y, 0.7);
  c.approach = -Vec3::UnitX();
  c.closing = Vec3::UnitZ();
  c.width = 0.025;
  return c;
}

// partner 0.4 m left of the centre of gravity
DecisionInput table() {
  DecisionInput in;
  in.partner.position = Vec3(-0.4, 0, 0.7);
  in.cog = Vec3(0, 0, 0.7);
  return in;
}

DecisionConfig wanting(double share) {
  DecisionConfig config;
  config.share = share;
  config.weights.epsilon = *epsilon_for_share(share);
  return config;
}

// 50, 57 and 67 % of the load, and 50 % beside the line
std::vector<GraspCandidate> rim() {
  return {at(0, 0.4, 0), at(1, 0.3, 0), at(2, 0.2, 0), at(3, 0.4, 0.1)};
}

}  // namespace

TEST_CASE("what can be had is the range of shares of all feasible grasps", "[share]") {
  auto c = rim();
  const auto d = decide_grasp(c, table(), wanting(0.3));
  REQUIRE(d);
  const auto range = reachable_shares(c, d->scores);
  REQUIRE(range);
  CHECK(range->low == Approx(0.5).margin(0.02));
  CHECK(range->high == Approx(2.0 / 3.0).epsilon(1e-9));
  CHECK(*d->nearest_share == Approx(range->low));
  for (GraspCandidate& one : c) one.verdict = Verdict::Collision;
  CHECK_FALSE(reachable_shares(c, d->scores));
}

TEST_CASE("a share beyond what anybody can bear is cut off at one", "[share]") {
  // partner and robot on the same side of the centre of gravity: he would have to press down
  std::vector<GraspCandidate> c{at(0, -0.1, 0)};
  DecisionConfig config;
  config.max_press = std::numeric_limits<double>::infinity();
  const auto d = decide_grasp(c, table(), config);
  REQUIRE(d);
  CHECK(d->scores[0]->share == Approx(4.0 / 3.0));
  CHECK(reachable_shares(c, d->scores)->high == 1.0);
}

TEST_CASE("a grasp with which somebody has to press the object down is refused, and says who", "[share]") {
  std::vector<GraspCandidate> c{at(0, -0.1, 0), at(1, 0.4, 0)};
  const auto d = decide_grasp(c, table(), {});
  REQUIRE((d && d->chosen));
  CHECK(*d->chosen == 1);
  CHECK(c[0].verdict == Verdict::OverLimit);
  CHECK(c[0].reason.find("the partner would have to press the object down with 33 %") != std::string::npos);
  SECTION("and so is one on the far side of the partner") {
    std::vector<GraspCandidate> beyond{at(0, -0.6, 0)};
    const auto none = decide_grasp(beyond, table(), {});
    REQUIRE(none);
    CHECK_FALSE(none->chosen);
    CHECK(none->reason.find("the robot would have to press the object down") != std::string::npos);
  }
  SECTION("a centre of gravity that is hardly beyond the robot's hand is within the limit") {
    std::vector<GraspCandidate> near{at(0, -0.01, 0)};
    const auto taken = decide_grasp(near, table(), {});
    REQUIRE(taken);
    CHECK(taken->chosen);
  }
}

TEST_CASE("a wanted share is weighed first, the cost decides among what comes near", "[share]") {
  auto c = rim();
  c[1].id = 7;
  SECTION("at 57 % only one comes near, however cheap the others are") {
    const auto d = decide_grasp(c, table(), wanting(0.57));
    REQUIRE((d && d->chosen));
    CHECK(c[*d->chosen].id == 7);
  }
  SECTION("at 30 % those with 50 % are nearest, and the one on the line is the cheaper of the two") {
    const auto d = decide_grasp(c, table(), wanting(0.3));
    REQUIRE((d && d->chosen));
    CHECK(*d->chosen == 0);
    CHECK(d->scores[3]->cost > d->cost);
    CHECK(comes_near_share(*d, 3, wanting(0.3)));
    CHECK_FALSE(comes_near_share(*d, 2, wanting(0.3)));
  }
  SECTION("the thesis's rule goes by cost alone") {
    DecisionConfig config = wanting(0.57);
    config.share_first = false;
    config.weights = SharingWeights::thesis();
    const auto d = decide_grasp(c, table(), config);
    REQUIRE((d && d->chosen));
    for (const auto& score : d->scores) CHECK(score->cost >= d->cost);
    CHECK_FALSE(d->nearest_share);
  }
}

TEST_CASE("without a wanted share the cost decides", "[share]") {
  auto c = rim();
  DecisionConfig config;
  config.weights.epsilon = *epsilon_for_share(0.3);
  const auto d = decide_grasp(c, table(), config);
  REQUIRE((d && d->chosen));
  for (const auto& score : d->scores) CHECK(score->cost >= d->cost);
  CHECK_FALSE(d->nearest_share);
}

TEST_CASE("beyond the strict deviation nothing is chosen, and the reason has the figures", "[share]") {
  auto c = rim();
  DecisionConfig config = wanting(0.3);
  config.share_strict = 0.1;
  const auto refused = decide_grasp(c, table(), config);
  REQUIRE(refused);
  CHECK_FALSE(refused->chosen);
  CHECK(refused->refused_for_share);
  CHECK(refused->reason.find("30 % of the load were wanted, the robot would carry 50 %") !=
        std::string::npos);
  CHECK(refused->reason.find("limit 10.0 %") != std::string::npos);
  CHECK(c[0].verdict == Verdict::Ok);

  c = rim();
  config.share_strict = 0.2;  // what is exactly at the limit is accepted
  const auto chosen = decide_grasp(c, table(), config);
  REQUIRE(chosen);
  CHECK(chosen->chosen);
}

TEST_CASE("the window does not lead beyond the strict deviation", "[share]") {
  // 50 % is nearest; 51.3 % would be within the window, but not within what was asked for
  std::vector<GraspCandidate> c{at(0, 0.4, 0.15), at(1, 0.38, 0)};
  DecisionConfig config = wanting(0.49);
  config.share_strict = 0.02;
  const auto d = decide_grasp(c, table(), config);
  REQUIRE(d);
  if (d->chosen) CHECK(std::abs(d->share - 0.49) <= 0.02);
}

TEST_CASE("a known mass limits the partner's load, an unknown one does not", "[share]") {
  DecisionConfig config;
  config.partner_load_n = 100.0;
  auto c = rim();
  CHECK(decide_grasp(c, table(), config)->chosen);
  CHECK(c[0].verdict != Verdict::OverLimit);
  config.known_mass_kg = 25.0;  // 245 N: half of it is too much for him, a third is not
  c = rim();
  const auto d = decide_grasp(c, table(), config);
  REQUIRE((d && d->chosen));
  CHECK(*d->chosen == 2);
  CHECK(c[0].verdict == Verdict::OverLimit);
  CHECK(c[0].reason.find("partner would bear 123 N of 25.0 kg (limit 100 N)") != std::string::npos);
  // what the caller measured counts before what was said
  DecisionInput in = table();
  in.mass_kg = 50.0;
  c = rim();
  CHECK_FALSE(decide_grasp(c, in, config)->chosen);
}

TEST_CASE("the lever rule is a matter of the level plane", "[share]") {
  const Vec3 up = Vec3::UnitZ();
  CHECK(*lever_share({0, 0, 0.5}, {-0.3, 0, 0.9}, {0.6, 0, 0.4}, up) == Approx(1.0 / 3.0));
  CHECK(*lever_share({0, 0.2, 0.5}, {-0.3, 0, 0.9}, {0.6, 0, 0.4}, up) == Approx(1.0 / 3.0));
  CHECK_FALSE(lever_share({0, 0, 0.5}, {0.1, 0, 0.9}, {0.1, 0, 0.4}, up));
}

}  // namespace colift::planner
