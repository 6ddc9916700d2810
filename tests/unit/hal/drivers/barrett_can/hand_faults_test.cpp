// What goes wrong with the hand itself, with the numbers of the fault table.
#include <optional>

#include "hand_rig.hpp"

using namespace colift;
using namespace std::chrono_literals;
using Catch::Matchers::Contains;
using hal::ErrorCode;

namespace {

std::optional<ErrorCode> fault(HandRig& rig) {
  const auto state = rig.hand.state();
  if (state) return std::nullopt;
  return state.error().code;
}

std::string words(HandRig& rig) {
  const auto state = rig.hand.state();
  return state ? std::string() : state.error().detail;
}

}  // namespace

TEST_CASE("row 25: a finger that does not move is noticed in half a second, and the hand does not hold",
          "[hand][faults]") {
  HandRig rig;
  rig.start();
  rig.fake.pucks[1].stuck = true;
  SECTION("its puck ends the move") {}
  SECTION("its puck goes on for ever") {
    rig.fake.pucks[1].never_ends = true;
  }
  rig.put_object(1.2);
  rig.fake.pucks[1].blocked_at = HUGE_VAL;
  REQUIRE(rig.hand.close(0.75));
  (void)until(rig, 600ms, [&] { return !rig.why().empty(); });
  CHECK_THAT(rig.why(), Contains("F2 does not move"));
  CHECK_FALSE(rig.settle().held);  // two fingers of three are not what was planned
  CHECK(rig.hand.preshape(0.0).error().code == ErrorCode::NotReady);  // F1 and F3 touch something
  REQUIRE(rig.hand.release());
  CHECK(rig.settle().finger_rad[0] < 0.01);
  rig.fake.pucks[1].stuck = false;  // one more try
  rig.grip();
}

TEST_CASE("row 25: when no finger moves the hand is still and empty", "[hand][faults]") {
  HandRig rig;
  rig.start();
  for (std::size_t f = 0; f < 3; ++f) rig.fake.pucks[f].stuck = rig.fake.pucks[f].never_ends = true;
  REQUIRE(rig.hand.close(0.75));
  const auto took = until(rig, 1s, [&] { return !rig.look().moving; });
  CHECK(took <= 650ms);
  CHECK_FALSE(rig.look().held);
  CHECK_FALSE(rig.hand.report().loaded);
  CHECK_THAT(rig.why(), Contains("does not move"));
  rig.pass(50ms);
  CHECK(rig.fake.pucks[0].mode() == 0);  // nobody pushes on
}

TEST_CASE("row 26: fingers that close on nothing hold nothing, and may open again", "[hand][faults]") {
  HandRig rig;
  rig.start();
  REQUIRE(rig.hand.close(0.75));
  const auto state = rig.settle();
  CHECK_FALSE(state.held);
  for (const double angle : state.finger_rad) CHECK(angle > 2.3);
  CHECK_THAT(rig.why(), Contains("closed on nothing"));
  CHECK(rig.hand.preshape(0.0));
}

TEST_CASE("row 26: fingers that stop early but feel nothing hold nothing", "[hand][faults]") {
  HandRig rig;
  rig.start();
  for (FakePuck& puck : rig.fake.pucks) puck.feels = false;
  rig.put_object(1.2);
  REQUIRE(rig.hand.close(0.75));
  CHECK_FALSE(rig.settle().held);
  CHECK_THAT(rig.why(), Contains("neither strain gauges nor pads measure a force"));
  // they may touch something all the same: release() opens, nothing else
  CHECK(rig.hand.preshape(0.0).error().code == ErrorCode::NotReady);
  REQUIRE(rig.hand.release());
  CHECK(rig.settle().finger_rad[0] < 0.01);
}

TEST_CASE("row 26: one side alone is no grip", "[hand][faults]") {
  HandRig rig;
  rig.start();
  rig.put_object(1.2);
  rig.fake.pucks[2].blocked_at = HUGE_VAL;
  REQUIRE(rig.hand.close(0.75));
  CHECK_FALSE(rig.settle().held);
}

TEST_CASE("row 27: a silent puck is noticed in 50 ms; loaded, the others keep their torque",
          "[hand][faults]") {
  HandRig rig;
  rig.start();
  rig.grip();
  const std::size_t from = rig.fake.from_host.size();
  rig.fake.pucks[1].silent = true;
  const auto took = until(rig, 100ms, [&] { return fault(rig).has_value(); });
  CHECK(took <= 50ms);
  CHECK(fault(rig) == ErrorCode::LinkLost);
  CHECK_THAT(words(rig), Contains("F2 (node 12) is silent"));
  CHECK(rig.hand.health().state == hal::DeviceHealth::State::Lost);
  rig.pass(1s);
  CHECK(rig.fake.pucks[0].mode() == 5);
  CHECK(rig.fake.pucks[2].mode() == 5);
  for (std::size_t p = 0; p < 4; ++p)
    for (const int property : {29, 43, 52}) CHECK(rig.fake.sets(p, property, from) == 0);
  CHECK(rig.hand.close(0.5).error().code == ErrorCode::LinkLost);

  SECTION("it answers again") {
    rig.fake.pucks[1].silent = false;
    (void)until(rig, 300ms, [&] { return !fault(rig); });
    CHECK(rig.look().held);
  }
  SECTION("the others can be released") {
    REQUIRE(rig.hand.release());
    rig.pass(2s);
    CHECK(rig.fake.pucks[0].position < 1000);
    CHECK(rig.fake.pucks[2].position < 1000);
    CHECK_FALSE(rig.hand.report().loaded);
  }
}

TEST_CASE("row 27: a puck that is silent alone is named by place; once released the others are told of",
          "[hand][faults]") {
  HandRig rig;
  rig.start();
  rig.put_object(1.2);
  REQUIRE(rig.hand.close(0.75));
  rig.pass(200ms);
  const double reached_rad = rig.look().finger_rad[1];
  rig.fake.pucks[1].silent = true;
  (void)until(rig, 100ms, [&] { return fault(rig).has_value(); });
  CHECK(rig.hand.state().error().where == "hand.f2.state");
  REQUIRE(rig.hand.release());
  rig.pass(2s);
  const auto state = rig.look();
  CHECK_FALSE(state.moving);
  CHECK(state.finger_rad[0] < 0.02);
  CHECK(state.finger_rad[1] > reached_rad - 0.02);  // as far as is known
  CHECK(state.finger_rad[2] < 0.02);
  CHECK_THAT(state.warning.str(), Contains("F2 is silent"));
  CHECK(rig.hand.health().last_error.find("F2") != std::string::npos);
  // it may not grip like that
  CHECK(rig.hand.close(0.5).error().code == ErrorCode::LinkLost);
  CHECK(rig.hand.preshape(0.0).error().code == ErrorCode::LinkLost);

  SECTION("it answers again") {
    rig.fake.pucks[1].silent = false;
    (void)until(rig, 500ms, [&] { return rig.look().warning.empty(); });
    rig.fake.pucks[1].silent = true;
    (void)until(rig, 100ms, [&] { return fault(rig).has_value(); });
  }
  SECTION("another falls silent") {
    rig.fake.pucks[0].silent = true;
    (void)until(rig, 100ms, [&] { return fault(rig).has_value(); });
    CHECK(rig.hand.state().error().where == "hand.state");
    CHECK_THAT(words(rig), Contains("F1 (node 11) is silent"));
  }
  SECTION("all fall silent") {
    for (auto& puck : rig.fake.pucks) puck.silent = true;
    (void)until(rig, 100ms, [&] { return fault(rig).has_value(); });
    rig.pass(50ms);
    CHECK_THAT(words(rig), Contains("all four pucks are silent") && Contains("bus-off"));
  }
}

TEST_CASE("row 27: a finger that falls silent while closing does not keep the hand from being released",
          "[hand][faults]") {
  HandRig rig;
  rig.start();
  rig.put_object(1.2);
  REQUIRE(rig.hand.close(0.75));
  rig.pass(200ms);
  rig.fake.pucks[2].silent = true;
  CHECK(until(rig, 100ms, [&] { return fault(rig).has_value(); }) <= 50ms);
  REQUIRE(rig.hand.release());
  rig.pass(2s);
  CHECK(rig.fake.pucks[0].position < 1000);
}

TEST_CASE("row 28: a warm hand holds with less torque, a hot one with its worms alone", "[hand][faults]") {
  HandRig rig;
  rig.start();
  rig.grip();
  rig.fake.pucks[1].property[20] = 62;
  CHECK(until(rig, 1s, [&] { return rig.hand.report().warm; }) <= 1s);
  rig.pass(50ms);
  CHECK(rig.fake.pucks[0].property[43] == 500);
  CHECK(rig.fake.pucks[0].mode() == 5);
  CHECK_THAT(rig.hand.health().last_error, Contains("62 C"));
  CHECK(rig.look().held);

  rig.fake.pucks[1].property[20] = 71;
  CHECK(until(rig, 1s, [&] { return rig.hand.report().hot; }) <= 1s);
  rig.pass(50ms);
  CHECK(rig.look().held);  // the grip is kept
  CHECK(rig.fake.pucks[0].mode() == 0);
  CHECK_THAT(rig.hand.health().last_error, Contains("lower the object"));
  CHECK(rig.fake.pucks[0].position == Approx(1.2 * 81487.33).margin(100));
}

TEST_CASE("a supply that sags is named before the pucks reset", "[hand][faults]") {
  HandRig rig;
  rig.start();
  rig.grip();
  rig.fake.pucks[2].property[21] = 21;
  CHECK(until(rig, 2s, [&] { return !rig.look().warning.empty(); }) <= 2s);
  CHECK_THAT(rig.look().warning.str(), Contains("supply gives 21 V") && Contains("below 18 V"));
  CHECK(rig.look().held);
  rig.fake.pucks[2].property[21] = 48;
  rig.pass(1s);
  CHECK(rig.look().warning.empty());
  for (const int no_voltage : {0, -3, 4000}) {  // what no supply gives is a bad frame
    rig.fake.pucks[2].property[21] = no_voltage;
    rig.pass(2s);
    CHECK(rig.look().warning.empty());
  }
}

TEST_CASE("row 28: a hot empty hand closes no more until it has cooled", "[hand][faults]") {
  HandRig rig;
  rig.start();
  rig.fake.pucks[3].property[9] = 72;
  rig.pass(1s);
  const auto refused = rig.hand.close(0.5);
  REQUIRE_FALSE(refused);
  CHECK(refused.error().code == ErrorCode::DeviceFault);
  CHECK_THAT(refused.error().detail, Contains("72 C"));
  CHECK(rig.hand.preshape(0.5));  // it may open and turn
  rig.settle();
  rig.fake.pucks[3].property[9] = 45;
  rig.pass(1s);
  CHECK(rig.hand.close(0.5));
}

TEST_CASE("row 29: a reset puck is noticed in 0.1 s, gets no commands, and is initialised anew when asked to",
          "[hand][faults]") {
  HandRig rig;
  rig.start();
  rig.pass(100ms);
  const std::size_t from = rig.fake.from_host.size();
  rig.fake.pucks[0].reset();
  CHECK(until(rig, 200ms, [&] { return fault(rig) == ErrorCode::DeviceFault; }) <= 100ms);
  CHECK_THAT(words(rig), Contains("F1 was reset") && Contains("initialised anew"));
  rig.pass(1s);
  for (std::size_t p = 0; p < 4; ++p)
    for (const int property : {5, 8, 29, 52}) CHECK(rig.fake.sets(p, property, from) == 0);
  CHECK(rig.hand.close(0.5).error().code == ErrorCode::DeviceFault);
  CHECK(rig.hand.preshape(0.5).error().code == ErrorCode::DeviceFault);
  REQUIRE(rig.hand.configure());  // a person has agreed
  REQUIRE(rig.hand.activate());
  rig.grip();
}

TEST_CASE("row 29: loaded, a reset puck opens nothing, and release comes before initialising",
          "[hand][faults]") {
  HandRig rig;
  rig.start();
  rig.grip();
  const double held_at = rig.fake.pucks[0].position;
  rig.fake.pucks[0].reset();
  CHECK(until(rig, 200ms, [&] { return fault(rig) == ErrorCode::DeviceFault; }) <= 100ms);
  CHECK_THAT(words(rig), Contains("support the object"));
  REQUIRE(rig.hand.configure());  // comes too early: nothing moves
  REQUIRE(rig.hand.activate());
  rig.pass(500ms);
  CHECK(rig.fake.pucks[0].position == held_at);
  CHECK(rig.fake.pucks[2].position == Approx(held_at).margin(300));
  CHECK(rig.fake.pucks[2].mode() == 5);
  CHECK(fault(rig) == ErrorCode::DeviceFault);
  REQUIRE(rig.hand.release());
  rig.pass(2s);
  CHECK(rig.fake.pucks[2].position < 1000);
  CHECK(rig.fake.pucks[0].position == held_at);  // its zero is elsewhere: nobody knows where "open" is
  REQUIRE(rig.hand.configure());
  REQUIRE(rig.hand.activate());
  CHECK(rig.fake.pucks[0].position < 1000);
  rig.grip();
}

TEST_CASE("row 29: a position that jumps once is dropped, one that stays has lost its zero",
          "[hand][faults]") {
  HandRig rig;
  rig.start();
  rig.grip();
  const auto before = rig.look();
  SECTION("once") {
    int left = 1;
    rig.fake.bus.fate = [&](const hal::CanFrame& f, const sim_hal::MemoryCan::Node*) {
      if (f.id == 0x583 && left-- > 0) const_cast<hal::CanFrame&>(f).data[0] ^= 0x01;  // 65 536 counts
      return sim_hal::MemoryCan::Fate{1, 150us};
    };
    for (int i = 0; i < 100; ++i) {
      rig.pass(1ms);
      CHECK(rig.look().finger_rad[1] == Approx(before.finger_rad[1]).margin(0.01));
    }
  }
  SECTION("for good") {
    rig.fake.pucks[1].zero_shift = -rig.fake.pucks[1].position;
    CHECK(until(rig, 200ms, [&] { return fault(rig) == ErrorCode::DeviceFault; }) <= 100ms);
    CHECK_THAT(words(rig), Contains("the encoder of F2 jumped by -97") && Contains("without a reset") &&
                               Contains("has lost its zero"));
    // nobody after us believes its zero
    rig.pass(10ms);
    CHECK(rig.fake.pucks[1].property[56] == 195000);
    // no finger closed, whatever the encoder says
    CHECK_FALSE(rig.hand.report().slipped);
  }
  SECTION("for good, and later it is reset as well") {
    rig.fake.pucks[1].zero_shift = -rig.fake.pucks[1].position;
    CHECK(until(rig, 200ms, [&] { return fault(rig) == ErrorCode::DeviceFault; }) <= 100ms);
    rig.fake.pucks[1].reset();
    rig.pass(200ms);
    CHECK_THAT(words(rig), Contains("F2 was reset and has lost its zero"));
  }
  SECTION("for good, by a reset from which another program woke it") {
    rig.fake.pucks[1].reset();
    rig.fake.pucks[1].stat = 2;
    CHECK(until(rig, 200ms, [&] { return fault(rig) == ErrorCode::DeviceFault; }) <= 100ms);
    CHECK_THAT(words(rig), Contains("F2 was reset and has lost its zero"));
  }
}

TEST_CASE("row 29: a jump that is not yet certain is not reported as a slip, of fingers and of the spread",
          "[hand][faults][slip]") {
  HandRig rig;
  rig.start();
  rig.grip();
  const std::size_t puck = GENERATE(0u, 3u);
  rig.fake.pucks[puck].zero_shift = 20000.0;
  bool slipped = false;
  rig.fake.pass(300ms, [&] {
    (void)rig.hand.state();
    slipped = slipped || rig.hand.report().slipped;
  });
  CHECK_FALSE(slipped);
  CHECK_THAT(words(rig), Contains("jumped by 20000 counts"));
}

TEST_CASE("row 29: a puck that falls out of its mode while it holds is noticed in 0.1 s", "[hand][faults]") {
  HandRig rig;
  rig.start();
  rig.grip();
  rig.fake.pucks[2].property[8] = 0;
  CHECK(until(rig, 200ms, [&] { return fault(rig) == ErrorCode::DeviceFault; }) <= 100ms);
  CHECK_THAT(words(rig), Contains("F3 has fallen out of its mode"));
  REQUIRE(rig.hand.release());
  rig.pass(2s);
  CHECK(rig.look().finger_rad[2] < 0.01);
}

TEST_CASE("a puck in error is told with its code", "[hand][faults]") {
  HandRig rig;
  rig.start();
  rig.fake.pucks[0].property[4] = 9;
  rig.fake.pucks[0].stat = 1;
  CHECK(until(rig, 200ms, [&] { return fault(rig) == ErrorCode::DeviceFault; }) <= 100ms);
  rig.pass(20ms);
  CHECK_THAT(words(rig), Contains("F1 reports an error (code 9)"));
}

TEST_CASE("an object that slips raises the alarm within 50 ms", "[hand][faults][slip]") {
  HandRig rig;
  rig.start();
  rig.grip();
  rig.pass(500ms);
  REQUIRE_FALSE(rig.hand.report().slipped);
  SECTION("the force is gone") {
    for (FakePuck& puck : rig.fake.pucks) puck.load_share = 0.3;
  }
  SECTION("the fingers close on") {
    rig.put_object(1.4);
  }
  CHECK(until(rig, 100ms, [&] { return rig.hand.report().slipped; }) <= 50ms);
  CHECK_THAT(rig.hand.health().last_error, Contains("slips"));
  rig.pass(100ms);
  CHECK(rig.hand.report().slipped);
  REQUIRE(rig.hand.release());
  CHECK_FALSE((rig.pass(10ms), rig.hand.report().slipped));
}

TEST_CASE("a load that changes slowly is no slip", "[hand][slip]") {
  HandRig rig;
  rig.start();
  rig.grip();
  for (int i = 0; i < 300; ++i) {
    for (FakePuck& puck : rig.fake.pucks) puck.load_share = 1.0 - 0.002 * i;
    rig.pass(10ms);
  }
  CHECK_FALSE(rig.hand.report().slipped);
  CHECK(rig.look().held);
}

TEST_CASE("an object that is gone altogether ends the grip", "[hand][slip]") {
  HandRig rig;
  rig.start();
  rig.grip();
  rig.put_object(10.0);
  (void)until(rig, 2s, [&] { return !rig.look().held; });
  CHECK(rig.hand.report().slipped);
  CHECK_THAT(rig.why(), Contains("grip is lost"));
  rig.pass(200ms);
  CHECK(rig.fake.pucks[0].mode() == 0);
}

TEST_CASE("more torque than was allowed is noticed, and the motors rest", "[hand][faults]") {
  HandRig rig;
  rig.start();
  rig.grip();
  rig.fake.bus.fate = [&](const hal::CanFrame& f, const sim_hal::MemoryCan::Node*) {
    if (f.id == 0x586 && f.data[0] == (0x80 | 42))
      const_cast<hal::CanFrame&>(f).data[3] = 0x0c;  // above 3000
    return sim_hal::MemoryCan::Fate{1, 150us};
  };
  CHECK(until(rig, 1s, [&] { return rig.hand.report().over_torque; }) <= 500ms);
  rig.pass(50ms);
  CHECK(rig.fake.pucks[1].mode() == 0);
  CHECK(rig.look().held);
  CHECK_THAT(rig.hand.health().last_error, Contains("F2 gives"));
}
