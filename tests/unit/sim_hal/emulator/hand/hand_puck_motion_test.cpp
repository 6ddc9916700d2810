// What the emulated pucks do with their motors: moves, stops, modes, heat, resets.
#include <catch2/catch.hpp>
#include <cmath>

#include "puck_bus.hpp"

using namespace colift;

TEST_CASE("a full stroke takes as long as the drive's figures say", "[hand][emulator]") {
  Bus b;
  b.set(kF1, prop::kE, 195000);
  b.set(kF1, prop::kMode, 5);
  const hal::Timestamp start = b.clock.now();
  while (b.hand.puck(0).value(prop::kMode) == 5 && b.clock.now() - start < 5s) b.pass(1ms);
  CHECK(hal::seconds(b.clock.now() - start) == Approx(1.23).margin(0.03));
  CHECK(b.position(0) == 195000);
  CHECK(b.mode(kF1) == 0);
  // both joints: 2.393 rad inner, a third of it outer
  CHECK(b.plant.joint(0).joint == Approx(195000 / 2.5).margin(1));

  b.set(kSpreadId, prop::kM, 35900);
  const hal::Timestamp turn = b.clock.now();
  while (b.hand.puck(3).value(prop::kMode) == 5 && b.clock.now() - turn < 5s) b.pass(1ms);
  CHECK(hal::seconds(b.clock.now() - turn) == Approx(0.78).margin(0.03));
  CHECK(b.mode(kSpreadId) == 3);  // HOLD is 1
  CHECK(b.hand.report().times(HandRule::FingersInTheWay) == 1);
}

TEST_CASE("initialising: silence, the way to the stop, zero", "[hand][emulator]") {
  Bus b;
  b.plant.place(0, 150'000);
  b.set(kF1, prop::kHold, 1);
  b.set(kF1, prop::kCmd, 13);
  b.pass(400ms);
  CHECK(b.ask(kF1, prop::kMode).empty());
  b.pass(300ms);
  CHECK(b.mode(kF1) == 5);
  b.pass(1s);
  CHECK(b.mode(kF1) == 5);  // 150 000 counts at 75 a millisecond
  b.pass(500ms);
  CHECK(b.mode(kF1) == 3);
  CHECK(b.position(0) == 0);
  CHECK(b.plant.joint(0).motor == Approx(0).margin(0.1));
}

TEST_CASE("what a client should not do is counted", "[hand][emulator]") {
  Bus b;
  b.set(kF1, prop::kCmd, 18);
  b.pass(300ms);
  b.set(kF1, prop::kE, 10'000);
  CHECK(b.hand.report().times(HandRule::NewEnd) == 1);
  b.set(kF1, prop::kMode, 0);
  b.set(kF1, prop::kE, 20'000);
  CHECK(b.hand.report().times(HandRule::NewEnd) == 1);
  b.set(kF1, prop::kMt, 6000);
  CHECK(b.hand.report().times(HandRule::TooMuchTorque) == 1);
  b.set(kF2, prop::kMode, 4);
  CHECK(b.hand.report().times(HandRule::StreamWithStop) == 1);
  b.say(kF2, {0x80 | prop::kMode, 0, 0, 0});
  b.say(kF2, {0x80 | prop::kMode, 0, 0, 0});
  b.pass(1ms);
  CHECK(b.hand.report().times(HandRule::Hurried) == 1);
  CHECK_FALSE(b.hand.report().first[static_cast<std::size_t>(HandRule::Hurried)].empty());
}

TEST_CASE("blocked: TSTOP ends the move; 0 lets it press", "[hand][emulator]") {
  Bus b;
  b.plant.put(HandObject::of_width(0.1));
  b.set(kF1, prop::kTstop, 100);
  b.set(kF1, prop::kCmd, 18);
  b.pass(1500ms);
  CHECK(b.mode(kF1) == 0);
  const int stalled = b.position(0);
  CHECK(stalled > 80'000);
  CHECK(stalled < 100'000);
  CHECK(b.value(kF1, prop::kSg) > 2500);
  CHECK(b.value(kF1, prop::kT) == 0);
  b.set(kF1, prop::kMt, 1100);
  b.set(kF1, prop::kTstop, 0);
  b.set(kF1, prop::kMode, 5);
  b.pass(1s);
  CHECK(b.mode(kF1) == 5);
  CHECK(b.position(0) == stalled);  // a worm is never turned back
  CHECK(b.value(kF1, prop::kT) == 1100);
  CHECK(b.value(kF1, prop::kImotor) > 2200);
}

TEST_CASE("a strain limit stops a closing finger, and the gauge protects itself", "[hand][emulator]") {
  Bus b;
  b.plant.put(HandObject::of_width(0.1));
  b.set(kF1, prop::kMt, 5000);
  b.set(kF1, prop::kTstop, 0);
  SECTION("HSG") {
    b.set(kF1, prop::kHsg, 2500);
    b.set(kF1, prop::kCmd, 18);
    b.pass(1500ms);
    CHECK(b.mode(kF1) == 0);
    CHECK(b.value(kF1, prop::kSg).value() >= 2500);
    CHECK(b.value(kF1, prop::kSg).value() < 3000);
  }
  SECTION("by itself") {
    b.set(kF1, prop::kCmd, 18);
    b.pass(1500ms);
    CHECK(b.mode(kF1) == 0);
    CHECK(b.value(kF1, prop::kSg).value() >= 3460);
  }
  SECTION("switched off") {
    b.set(kF1, prop::kHsg, 10000);
    b.set(kF1, prop::kCmd, 18);
    b.pass(1500ms);
    CHECK(b.mode(kF1) == 5);
  }
}

TEST_CASE("speed, position and torque modes, streams and stops", "[hand][emulator]") {
  Bus b;
  b.set(kF2, prop::kTstop, 0);
  b.set(kF2, prop::kV, 100);
  b.set(kF2, prop::kMode, 4);
  b.pass(500ms);
  CHECK(b.position(1) == Approx(50'000).epsilon(0.02));
  CHECK(b.value(kF2, prop::kV) == 100);
  b.pass(3s);
  CHECK(b.position(1) == 195'000);  // CT
  b.set(kF2, prop::kMode, 3);
  b.set(kF2, prop::kP, 190'000);
  b.pass(300ms);
  CHECK(b.position(1) == Approx(190'000).margin(3));
  b.set(kF2, prop::kT, -1000);
  b.set(kF2, prop::kMode, 2);
  b.pass(100ms);
  CHECK(b.position(1) < 185'000);
  b.set(kF2, prop::kCmd, 21);
  b.pass(1ms);
  const int here = b.position(1);
  b.pass(100ms);
  CHECK(b.position(1) == here);
  b.set(kF2, prop::kP, 5);  // idle: from now on this is 5
  CHECK(b.position(1) == 5);
  CHECK(b.hand.report().times(HandRule::StreamWithStop) == 0);
}

TEST_CASE("heat takes the torque away", "[hand][emulator]") {
  Bus b;
  auto hot = parse_hand_fault("0:hot=60@F1:5");
  REQUIRE(hot);
  b.hand.inject(*hot);
  b.pass(2ms);
  CHECK(b.value(kF1, prop::kTemp) == 60);
  b.set(kF1, prop::kCmd, 18);
  b.set(kF2, prop::kCmd, 18);
  b.pass(1s);
  CHECK(b.position(0) == 0);
  CHECK(b.position(1) > 100'000);
  // half of it 8 degrees below OTEMP
  auto warm = parse_hand_fault("0:hot=52@F3:10");
  REQUIRE(warm);
  b.hand.inject(*warm);
  b.plant.put(HandObject::of_width(0.1));
  b.set(kF3, prop::kTstop, 0);
  b.set(kF3, prop::kMt, 2000);
  b.set(kF3, prop::kCmd, 18);
  b.pass(1500ms);
  CHECK(std::abs(b.value(kF3, prop::kT).value_or(0) - 1000) < 5);
}

TEST_CASE("pressing for minutes makes a puck warm", "[hand][emulator]") {
  Bus b;
  b.plant.put(HandObject::of_width(0.1));
  b.set(kF1, prop::kTstop, 0);
  b.set(kF1, prop::kCmd, 18);
  const int before = b.value(kF1, prop::kTherm).value();
  b.pass(120s);
  CHECK(b.value(kF1, prop::kTherm).value() > before + 15);
}

TEST_CASE("a reset loses zero and settings, and what was saved is back", "[hand][emulator]") {
  Bus b;
  b.set(kF1, prop::kCmd, 19);
  b.pass(1s);
  CHECK(b.position(0) == 45000);
  b.set(kF1, prop::kMv, 120);
  b.set(kF1, prop::kMt, 1500);
  b.set(kF1, prop::kSave, prop::kMv);
  b.set(kF1, prop::kCmd, 2);
  CHECK(b.value(kF1, prop::kStat) == 0);
  b.set(kF1, prop::kStat, 2);
  b.pass(1s);
  CHECK(b.value(kF1, prop::kMv) == 120);
  CHECK(b.value(kF1, prop::kMt) == 2200);
  CHECK(b.position(0) == 0);
}

TEST_CASE("a supply that is too weak resets all four", "[hand][emulator]") {
  HandEmulatorConfig c = Bus::awake();
  c.brown_out_units = 5000;
  Bus b{c};
  b.plant.put(HandObject::of_width(0.1));
  for (const int id : {0x00b, 0x00c, 0x00d}) {
    b.set(id, prop::kTstop, 0);
    b.set(id, prop::kCmd, 18);
  }
  b.pass(2s);
  for (std::size_t p = 0; p < 4; ++p) CHECK_FALSE(b.hand.puck(p).ready());
}
