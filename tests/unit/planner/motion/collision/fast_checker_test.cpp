#include <catch2/catch.hpp>

#include "collision_world.hpp"

namespace {

using namespace colift;
using planner::Contacts;
using planner::Touch;

const test::CollisionWorld& world() {
  static const test::CollisionWorld made;
  return made;
}

const planner::SphereModel& spheres() {
  static const planner::SphereModel made = planner::cover_with_spheres(hal::built_in_robot());
  return made;
}

struct Counts {
  int missed = 0, over_cautious = 0, exact_free = 0;
};

template <class Next>
Counts compare(planner::FastChecker& fast, planner::ExactChecker& exact, int states, Next next) {
  Counts counts;
  for (int i = 0; i < states; ++i) {
    const hal::JointVector q = next();
    const bool free = fast.is_free(q);
    const Touch touch = exact.what_touches(q);
    const bool truly = touch.with == Touch::With::Nothing;
    counts.exact_free += truly;
    if (free && !truly) {
      ++counts.missed;
      UNSCOPED_INFO(touch.text() << " at " << q.transpose());
    }
    counts.over_cautious += !free && truly;
  }
  return counts;
}

planner::SceneConfig bare() {
  planner::SceneConfig config;
  config.margin_m = 0.0;
  config.ground_clearance_m = 0.0;
  config.hidden_is_obstacle = false;
  return config;
}

}  // namespace

TEST_CASE("the fast checker misses no collision of random joint positions, without any margin") {
  planner::FastChecker fast(hal::built_in_robot(), spheres(), world().scene(bare()));
  planner::ExactChecker exact(hal::built_in_robot(), world().map, world().ground);
  sim_hal::Draws draws(3, 1);
  const Counts counts = compare(fast, exact, 20000, [&] { return test::draw_joints(draws); });
  CHECK(counts.missed == 0);
  CHECK(counts.exact_free > 2000);
  CHECK(counts.over_cautious < counts.exact_free / 5);
}

TEST_CASE("the fast checker misses no collision near the object, without any margin") {
  planner::FastChecker fast(hal::built_in_robot(), spheres(), world().scene(bare()));
  planner::ExactChecker exact(hal::built_in_robot(), world().map, world().ground);
  test::NearTable near(5);
  for (const Contacts contacts : {Contacts::None, Contacts::FingersOnTarget}) {
    fast.allow(contacts);
    exact.allow(contacts);
    const auto posture = hal::coupled_posture(contacts == Contacts::None ? 0.0 : 0.9, 0.4);
    fast.set_hand(posture);
    exact.set_hand(posture);
    const Counts counts = compare(fast, exact, 10000, [&] { return near.next(); });
    CHECK(counts.missed == 0);
    CHECK(counts.exact_free > 500);
    CHECK(counts.over_cautious < counts.exact_free / 5);
  }
}

TEST_CASE("a joint position is free exactly where nothing is said to be touched") {
  planner::FastChecker fast(hal::built_in_robot(), spheres(), world().scene());
  test::NearTable near(9);
  int free = 0;
  for (int i = 0; i < 5000; ++i) {
    const hal::JointVector q = near.next();
    const Touch touch = fast.what_touches(q);
    const bool is_free = fast.is_free(q);
    REQUIRE(is_free == (touch.with == Touch::With::Nothing));
    if (!is_free) REQUIRE((touch.depth_m > 0.0 && !touch.part.empty()));
    free += is_free;
  }
  CHECK(free > 20);
}

TEST_CASE("a motion is free exactly when all its states are") {
  planner::FastChecker fast(hal::built_in_robot(), spheres(), world().scene());
  sim_hal::Draws draws(11, 1);
  int free = 0, steps_asked = 0;
  for (int i = 0; i < 600; ++i) {
    const hal::JointVector a = test::draw_joints(draws);
    const hal::JointVector b = a + 0.3 * draws.between(0, 1) * (test::draw_joints(draws) - a);
    const int steps = std::max(1, static_cast<int>(std::ceil((b - a).cwiseAbs().maxCoeff() / 0.05)));
    bool all = true;
    for (int k = 0; k <= steps && all; ++k)
      all = fast.is_free(a + (static_cast<double>(k) / steps) * (b - a));
    const std::size_t before = fast.checks();
    REQUIRE(fast.is_free(a, b, 0.05) == all);
    if (all) {
      REQUIRE(fast.checks() - before == static_cast<std::size_t>(steps) + 1);
      ++free;
      steps_asked += steps;
    }
  }
  CHECK(free > 20);
  CHECK(steps_asked > 100);
}

TEST_CASE("joint positions beyond a limit are not free") {
  planner::FastChecker fast(hal::built_in_robot(), spheres(), world().scene());
  hal::JointVector q = hal::JointVector::Zero();
  q[3] = hal::built_in_robot().upper_rad()[3] + 0.01;
  CHECK_FALSE(fast.is_free(q));
  const Touch touch = fast.what_touches(q);
  CHECK(touch.with == Touch::With::Limits);
  CHECK(touch.depth_m == Approx(0.01).margin(1e-4));
  q[3] = std::nan("");
  CHECK_FALSE(fast.is_free(q));
  CHECK(fast.what_touches(q).with == Touch::With::Limits);
}
