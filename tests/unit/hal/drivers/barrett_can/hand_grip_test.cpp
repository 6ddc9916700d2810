#include "hand_rig.hpp"

using namespace colift;
using namespace std::chrono_literals;
using Catch::Matchers::Contains;
using hal::ErrorCode;

TEST_CASE("a hand does nothing before it is ready", "[hand]") {
  HandRig rig;
  CHECK(rig.hand.state().error().code == ErrorCode::NotReady);
  CHECK(rig.hand.activate().error().code == ErrorCode::NotReady);
  rig.hand.stop();
  rig.hand.deactivate();
  REQUIRE(rig.hand.configure());
  CHECK(rig.hand.close(0.5).error().code == ErrorCode::NotReady);
  CHECK(rig.hand.release().error().code == ErrorCode::NotReady);
  CHECK(rig.hand.preshape(0.0).error().code == ErrorCode::NotReady);
  CHECK(rig.hand.state());
}

TEST_CASE("preshape opens the fingers first and turns the spread then", "[hand]") {
  HandRig rig;
  rig.start();
  REQUIRE(rig.hand.close(0.5));
  rig.settle();
  REQUIRE(rig.look().finger_rad[0] > 2.3);
  REQUIRE(rig.hand.preshape(0.8));
  CHECK(rig.look().moving);
  bool turned_early = false;
  rig.fake.pass(2500ms, [&] {
    (void)rig.hand.state();
    turned_early = turned_early || (rig.fake.pucks[3].position > 200 && rig.fake.pucks[1].position > 4000);
  });
  CHECK_FALSE(turned_early);
  const auto state = rig.settle();
  CHECK(state.spread_rad == Approx(0.8).margin(0.01));
  for (const double angle : state.finger_rad) CHECK(std::abs(angle) < 0.01);
  CHECK(rig.fake.pucks[3].mode() == 3);  // keeps its place
  CHECK(rig.why().empty());
}

TEST_CASE("fingers close only after the spread has arrived", "[hand]") {
  HandRig rig;
  rig.start();
  rig.put_object(1.2);
  REQUIRE(rig.hand.preshape(3.0));
  rig.pass(150ms);
  REQUIRE(rig.hand.close(0.75));
  CHECK(rig.look().moving);
  bool early = false;
  rig.fake.pass(1500ms, [&] {
    (void)rig.hand.state();
    early =
        early || (rig.fake.pucks[0].position > 500 && std::abs(rig.fake.pucks[3].position - 34'225) > 300);
  });
  CHECK_FALSE(early);
  CHECK(rig.settle().held);
}

TEST_CASE("closing around something ends held: position, strain and pads agree", "[hand]") {
  HandRig rig;
  rig.start();
  rig.put_object(1.2);
  REQUIRE(rig.hand.close(0.75));
  CHECK(rig.look().moving);
  CHECK_FALSE(rig.look().held);
  rig.pass(200ms);
  CHECK(rig.look().moving);
  const auto state = rig.settle();
  CHECK(state.held);
  CHECK(rig.hand.report().loaded);
  for (std::size_t f = 0; f < 3; ++f) {
    CHECK(state.finger_rad[f] == Approx(1.2).margin(0.01));
    CHECK(state.outer_rad[f] == Approx(0.4).margin(0.01));
    CHECK(state.torque_nm[f] > 0.09);
    CHECK(state.tip_force_n[f] > 0.3);
    CHECK(rig.fake.pucks[f].mode() == 5);  // goes on pressing ...
    // ... with the holding torque, but F1 and F2 with half of what was wished: F3 bears both
    CHECK(rig.fake.pucks[f].property[43] == (f == 2 ? 1100 : 1087));
    CHECK(rig.fake.pucks[f].property[78] == 1000);
  }
  rig.pass(3s);
  CHECK(rig.look().held);
  CHECK(rig.look().finger_rad == state.finger_rad);

  CHECK(rig.hand.preshape(0.0).error().code == ErrorCode::NotReady);
  REQUIRE(rig.hand.release());
  CHECK_FALSE(rig.look().held);
  const auto open = rig.settle();
  for (const double angle : open.finger_rad) CHECK(std::abs(angle) < 0.01);
  CHECK_FALSE(rig.hand.report().loaded);
  CHECK(rig.hand.preshape(0.0));
}

TEST_CASE("the puck itself is given the strain at which it has to stop", "[hand]") {
  HandRig rig;
  rig.start();
  rig.put_object(1.2);
  REQUIRE(rig.hand.close(0.3));
  rig.pass(50ms);
  CHECK(rig.fake.pucks[0].property[71] > 2100);  // half of 0.3 N m
  CHECK(rig.fake.pucks[0].property[71] < rig.fake.pucks[2].property[71]);
  CHECK(rig.fake.pucks[2].property[71] > 2300);
  CHECK(rig.fake.pucks[2].property[71] < 3000);
  CHECK(rig.fake.pucks[2].property[43] == 870);
  CHECK(rig.fake.pucks[0].property[43] == 700);  // what overcomes its friction
}

TEST_CASE("a hand that is stopped stays where it is, and can be closed again", "[hand]") {
  HandRig rig;
  rig.start();
  rig.put_object(1.2);
  REQUIRE(rig.hand.close(0.75));
  rig.pass(300ms);
  rig.hand.stop();
  rig.hand.stop();
  rig.pass(100ms);
  const auto state = rig.look();
  CHECK_FALSE(state.moving);
  CHECK_FALSE(state.held);
  CHECK(state.finger_rad[0] > 0.05);
  CHECK(state.finger_rad[0] < 1.1);
  rig.pass(2s);
  CHECK(rig.look().finger_rad[0] == Approx(state.finger_rad[0]).margin(0.01));
  REQUIRE(rig.hand.close(0.75));
  CHECK(rig.settle().held);
  REQUIRE(rig.hand.close(0.75));  // and once more around the same thing
  CHECK(rig.settle().held);
}

TEST_CASE("a spread that is stopped on its way keeps its place", "[hand]") {
  HandRig rig;
  rig.start();
  REQUIRE(rig.hand.preshape(3.0));
  rig.pass(250ms);
  rig.hand.stop();
  rig.pass(100ms);
  const double at = rig.look().spread_rad;
  CHECK(at > 0.1);
  CHECK(at < 2.5);
  rig.pass(1s);
  CHECK(rig.look().spread_rad == Approx(at).margin(0.05));
  CHECK(rig.fake.pucks[3].mode() == 3);
}

TEST_CASE("a loaded hand stays closed when it is stopped, put to rest and woken again", "[hand]") {
  HandRig rig;
  rig.start();
  rig.grip();
  const double at = rig.fake.pucks[0].position;
  rig.hand.stop();
  rig.pass(300ms);
  CHECK(rig.look().held);
  CHECK(rig.fake.pucks[0].mode() == 5);
  rig.hand.deactivate();
  rig.fake.pass(2s);
  CHECK(rig.fake.pucks[0].mode() == 0);  // no current: the worm holds
  CHECK(rig.hand.release().error().code == ErrorCode::NotReady);
  REQUIRE(rig.hand.activate());
  CHECK(rig.look().held);
  rig.pass(200ms);
  CHECK(rig.fake.pucks[0].mode() == 5);  // presses again
  CHECK(rig.fake.pucks[0].position == Approx(at).margin(10));
  CHECK(rig.look().held);
}

TEST_CASE("requests beyond what the hand can do are refused and start nothing", "[hand]") {
  HandRig rig;
  rig.start();
  const double nan = std::nan(""), inf = HUGE_VAL;
  const std::size_t from = rig.fake.from_host.size();
  for (const double torque : {nan, inf, -inf, -0.5, 0.0, 1.01})
    CHECK(rig.hand.close(torque).error().code == ErrorCode::LimitExceeded);
  for (const double spread : {nan, inf, -0.1, 3.2})
    CHECK(rig.hand.preshape(spread).error().code == ErrorCode::LimitExceeded);
  rig.pass(100ms);
  CHECK_FALSE(rig.look().moving);
  for (std::size_t p = 0; p < 4; ++p) CHECK(rig.fake.sets(p, 8, from) == 0);
}

TEST_CASE("positions, strain and pads come at 100 Hz, and the bus is not full of questions", "[hand]") {
  HandRig rig;
  rig.start();
  rig.grip();
  int positions = 0, strains = 0, pads = 0, frames = 0;
  rig.fake.bus.tap = [&](const hal::CanFrame& f) {
    ++frames;
    positions += f.id == 0x563;
    strains += f.id == 0x566 && f.data[0] == 0x99;
    pads += f.id == 0x569 && f.data[0] >> 4 == 4;
  };
  rig.pass(1s);
  CHECK(positions >= 95);
  CHECK(strains >= 90);
  CHECK(pads >= 80);
  CHECK(frames < 5000);  // a frame takes 0.13 ms at most
  CHECK(rig.hand.health().rejected == 0);
}

TEST_CASE("breakaway is told, and the outer link is measured with it", "[hand]") {
  HandRig rig;
  rig.start();
  rig.grip();
  // the inner link stands, the motor has gone on
  rig.fake.bus.fate = [&](const hal::CanFrame& f, const sim_hal::MemoryCan::Node*) {
    if (f.id == 0x563) {
      auto& joint = const_cast<hal::CanFrame&>(f).data;
      joint[3] = 0x80, joint[4] = 0x75, joint[5] = 0x30;  // 30 000 counts of 39 114
    }
    return sim_hal::MemoryCan::Fate{1, 150us};
  };
  rig.pass(100ms);
  CHECK(rig.hand.report().broken_away[0]);
  CHECK_FALSE(rig.hand.report().broken_away[1]);
  CHECK(rig.look().finger_rad[0] == Approx(30'000 / 32594.93).margin(1e-3));
  CHECK(rig.look().outer_rad[0] == Approx(1.2 * 81487.33 / 61115.5 - 30'000 / 32594.93).margin(1e-2));
}

TEST_CASE("a hand that nobody asked for a while gives a fresh state at once", "[hand]") {
  HandRig rig;
  rig.start();
  rig.pass(100ms);
  rig.fake.pass(3s);  // the pucks live on, the driver is not called
  const hal::Timestamp before = rig.clock.now();
  const auto state = rig.look();
  CHECK(state.measured_at > before);
  CHECK(rig.clock.now() - before < 5ms);
}

TEST_CASE("the same calls give the same states", "[hand]") {
  const auto run = [] {
    HandRig rig;
    rig.start();
    rig.put_object(0.9);
    REQUIRE(rig.hand.close(0.6));
    std::vector<hal::HandState> states;
    for (int i = 0; i < 40; ++i) {
      rig.pass(50ms);
      states.push_back(rig.look());
    }
    return states;
  };
  const auto one = run(), other = run();
  for (std::size_t i = 0; i < one.size(); ++i) {
    CHECK(one[i].finger_rad == other[i].finger_rad);
    CHECK(one[i].measured_at == other[i].measured_at);
    if (i > 0) CHECK(one[i].measured_at > one[i - 1].measured_at);
  }
}
