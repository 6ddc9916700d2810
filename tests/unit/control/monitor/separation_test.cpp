#include "control/monitor/separation.hpp"

#include <catch2/catch.hpp>
#include <chrono>

#include "control/monitor/separation_monitor.hpp"

using namespace colift;
using namespace colift::control;
using namespace std::chrono_literals;

namespace {

Neighbour person(double distance_m) {
  Neighbour n;
  n.distance_m = distance_m;
  return n;
}

/// After a stop an operator confirms.
MonitorConfig confirmed_config() {
  MonitorConfig config;
  config.resume = false;
  return config;
}

/// A second of frames with the same neighbours; the state after it.
SeparationState second(SeparationMonitor& monitor, hal::Timestamp& now, std::vector<Neighbour> near) {
  for (int i = 0; i < 30; ++i) monitor.update(now += 33'333'333ns, true, near, 0.0, 14.0);
  return monitor.state();
}

}  // namespace

TEST_CASE("the separation distances are those of the reference table") {
  const MonitorConfig config;
  CHECK(separation_distance(0.25, 1.6, 0.15, config) == Approx(0.86).margin(0.005));
  CHECK(separation_distance(0.15, 1.6, 0.15, config) == Approx(0.67).margin(0.005));
}

TEST_CASE("the allowed speed is the one whose separation distance is the measured one") {
  const MonitorConfig config;
  for (const double person : {0.0, 0.3, 1.6})
    for (double d = 0.1; d < 2.0; d += 0.05) {
      const double v = allowed_speed(d, person, 0.2, config);
      CHECK(v >= 0.0);
      if (v > 0.0) CHECK(separation_distance(v, person, 0.2, config) == Approx(d));
      CHECK(allowed_speed(d + 0.05, person, 0.2, config) >= v);
      CHECK(allowed_speed(d, person, 0.3, config) <= v);
    }
  CHECK(allowed_speed(-0.1, 1.6, 0.15, config) == 0.0);
  CHECK(allowed_speed(NAN, 1.6, 0.15, config) == 0.0);
}

TEST_CASE("contact speeds are those at which the table's forces are reached") {
  // at 0.25 m/s the table has 52 N for a hand and 66 N for a lower arm, of 140 and 160 N
  CHECK(contact_speed(BodyRegion::Hand, 14.0) == Approx(0.25 * 140 / 52.0).epsilon(0.01));
  CHECK(contact_speed(BodyRegion::LowerArm, 14.0) == Approx(0.25 * 160 / 66.0).epsilon(0.01));
  CHECK(contact_speed(BodyRegion::Face, 14.0) == Approx(0.25 * 65 / 125.0).epsilon(0.01));
}

TEST_CASE("nobody: no limit; somebody far: none that counts; nearer: slower; too near: the arm stops") {
  SeparationMonitor monitor{{}};
  hal::Timestamp now{0};
  CHECK_FALSE(second(monitor, now, {}).limited);
  CHECK(second(monitor, now, {person(1.2)}).speed_m_s > 0.25);
  const double slow = second(monitor, now, {person(0.75)}).speed_m_s;
  CHECK(slow < 0.25);
  CHECK(slow > 0.1);
  CHECK_FALSE(monitor.state().hold);
  const SeparationState held = second(monitor, now, {person(1.2), person(0.6)});
  CHECK(held.hold);
  CHECK(held.speed_m_s == 0.0);
  CHECK(held.nearest.distance_m == 0.6);
}

TEST_CASE("after SLOW it resumes at once, after a stop when nobody has been near for two seconds") {
  SeparationMonitor monitor{{}};
  hal::Timestamp now{0};
  CHECK(second(monitor, now, {person(0.75)}).limited);
  monitor.update(now += 33ms, true, {}, 0.0, 14.0);
  CHECK_FALSE(monitor.state().limited);

  CHECK(second(monitor, now, {person(0.5)}).hold);
  CHECK(second(monitor, now, {}).hold);
  CHECK(second(monitor, now, {person(0.705)}).hold);  // within the hysteresis: the time begins anew
  CHECK(second(monitor, now, {}).hold);
  CHECK(second(monitor, now, {person(0.9)}).hold);
  CHECK_FALSE(second(monitor, now, {}).hold);
}

TEST_CASE("whoever was near before the arm moved makes its start wait, and has stopped nothing") {
  SeparationMonitor monitor{{}};
  hal::Timestamp now{0};
  const Neighbour near[] = {person(0.5)};
  CHECK(monitor.update(now += 33ms, false, near, 0.0, 14.0).hold);
  CHECK_FALSE(monitor.state().stopped);
  // a frame in which he is not seen starts nothing
  CHECK(monitor.update(now += 33ms, false, {}, 0.0, 14.0).hold);
  CHECK_FALSE(monitor.update(now += 300ms, false, {}, 0.0, 14.0).hold);
  // the arm moves: the next one is a stop
  CHECK(monitor.update(now += 33ms, true, near, 0.0, 14.0).stopped);
  CHECK(monitor.update(now += 300ms, false, {}, 0.0, 14.0).hold);
}

// ---- a stop after which an operator confirms ----

TEST_CASE("a stop that is not to be left by itself is not, and an arm that only slowed is") {
  hal::Timestamp now{0};
  SeparationMonitor strict{confirmed_config()};
  CHECK(second(strict, now, {person(0.75)}).limited);
  strict.update(now += 33ms, true, {}, 0.0, 14.0);
  CHECK_FALSE(strict.state().hold);
  (void)second(strict, now, {person(0.5)});
  for (int i = 0; i < 5; ++i) CHECK(second(strict, now, {}).hold);
}

TEST_CASE("a confirmation continues an arm that stopped, once nobody is near") {
  hal::Timestamp now{0};
  SeparationMonitor monitor{confirmed_config()};
  CHECK(second(monitor, now, {person(0.5)}).to_confirm);
  (void)second(monitor, now, {person(1.2)});
  CHECK(monitor.state().may_confirm);
  CHECK(monitor.state().held_for == Nearby::Person);
  CHECK(monitor.confirm());
  CHECK_FALSE(monitor.state().hold);
  CHECK(monitor.state().limited);  // by who is at 1.2 m
  CHECK(monitor.state().speed_m_s > 0.0);
  CHECK_FALSE(monitor.confirm());  // once more is nothing
  CHECK_FALSE(second(monitor, now, {}).hold);
}

TEST_CASE(
    "a confirmation has no effect before the stop, while somebody is near, or in the first free frame") {
  hal::Timestamp now{0};
  SeparationMonitor monitor{confirmed_config()};
  CHECK_FALSE(monitor.confirm());  // stale: nothing waits
  CHECK(second(monitor, now, {person(0.5)}).hold);
  CHECK_FALSE(monitor.confirm());                     // early: he is still there
  CHECK(second(monitor, now, {person(0.705)}).hold);  // within the hysteresis
  CHECK_FALSE(monitor.confirm());
  monitor.update(now += 33ms, true, {}, 0.0, 14.0);
  CHECK_FALSE(monitor.confirm());  // one frame in which he is not seen is no free path
  CHECK(second(monitor, now, {}).hold);
  CHECK(monitor.confirm());
}

TEST_CASE("whoever comes near again after a confirmation is to be confirmed anew") {
  hal::Timestamp now{0};
  SeparationMonitor monitor{confirmed_config()};
  const Neighbour near[] = {person(0.5)};
  (void)second(monitor, now, {person(0.5)});
  (void)second(monitor, now, {});
  REQUIRE(monitor.confirm());
  SECTION("while the arm's continuation is announced, and it has not moved yet") {
    CHECK_FALSE(monitor.update(now += 33ms, false, {}, 0.0, 14.0).hold);
    CHECK(monitor.update(now += 33ms, false, near, 0.0, 14.0).to_confirm);
  }
  SECTION("while it moves") {
    CHECK_FALSE(monitor.update(now += 33ms, true, {}, 0.0, 14.0).hold);
    CHECK(monitor.update(now += 33ms, true, near, 0.0, 14.0).to_confirm);
  }
  for (int i = 0; i < 100; ++i) CHECK(monitor.update(now += 33ms, false, {}, 0.0, 14.0).hold);
  CHECK(monitor.confirm());
}

TEST_CASE(
    "an arm that has not begun to move needs no confirmation, and one that resumes by itself takes none") {
  hal::Timestamp now{0};
  SeparationMonitor strict{confirmed_config()};
  const Neighbour near[] = {person(0.5)};
  CHECK_FALSE(strict.update(now += 33ms, false, near, 0.0, 14.0).to_confirm);
  CHECK_FALSE(strict.update(now += 400ms, false, {}, 0.0, 14.0).hold);

  SeparationMonitor monitor{{}};
  (void)second(monitor, now, {person(0.5)});
  CHECK_FALSE(second(monitor, now, {}).may_confirm);
  CHECK_FALSE(monitor.confirm());
  CHECK(monitor.state().hold);
}

TEST_CASE("the partner at rest may be nearer than anybody else, and not when he moves fast") {
  SeparationMonitor monitor{{}};
  hal::Timestamp now{0};
  Neighbour partner = person(0.45);
  partner.who = Nearby::Partner;
  partner.speed_m_s = 0.05;
  CHECK(second(monitor, now, {partner}).speed_m_s > 0.25);
  partner.speed_m_s = 1.6;
  CHECK(second(monitor, now, {partner}).speed_m_s < 0.1);
  partner.speed_m_s = 0.05;
  partner.distance_m = 0.15;
  CHECK(second(monitor, now, {partner}).hold);
}

TEST_CASE("the partner's hand at the object limits by force: never below the speed that does not hurt") {
  SeparationMonitor monitor{{}};
  hal::Timestamp now{0};
  Neighbour hand = person(0.02);
  hand.who = Nearby::PartnerHand;
  const SeparationState state = second(monitor, now, {hand});
  CHECK_FALSE(state.hold);
  CHECK(state.speed_m_s > 0.25);
}

TEST_CASE("a slow camera chain counts: a longer latency is a lower speed") {
  SeparationMonitor monitor{{}};
  hal::Timestamp now{0};
  const Neighbour near[] = {person(0.8)};
  const double quick = monitor.update(now += 33ms, true, near, 0.02, 14.0).speed_m_s;
  const double late = monitor.update(now += 33ms, true, near, 0.25, 14.0).speed_m_s;
  CHECK(late < quick);
}

TEST_CASE("the arm leaves a thing that stands beside it slowly, and no person") {
  SeparationMonitor monitor{MonitorConfig{}};
  hal::Timestamp now{0};
  Neighbour thing = person(0.05);
  thing.who = Nearby::Thing;
  CHECK(second(monitor, now, {thing}).hold);
  thing.behind = true;  // the rest of the path leads away from it
  (void)second(monitor, now, {thing});
  (void)second(monitor, now, {thing});
  const SeparationState state = second(monitor, now, {thing});
  CHECK_FALSE(state.hold);
  CHECK(state.speed_m_s == Approx(0.05));
  thing.distance_m = 0.02;  // a contact by all that is known
  CHECK(second(monitor, now, {thing}).hold);
  Neighbour somebody = person(0.05);
  somebody.behind = true;
  CHECK(second(monitor, now, {somebody}).hold);
}

TEST_CASE("why the arm waits is said with the figure") {
  Neighbour n = person(0.424);
  CHECK(describe(n) == "a person is 0.42 m from the arm");
  n.to_path = true;
  CHECK(describe(n) == "a person is 0.42 m from the arm's path");
}
