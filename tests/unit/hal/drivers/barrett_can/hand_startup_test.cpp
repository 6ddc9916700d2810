#include "hand_rig.hpp"

using namespace colift;
using namespace std::chrono_literals;
using Catch::Matchers::Contains;
using hal::ErrorCode;

namespace {

std::string failure_of(HandRig& rig) {
  const auto configured = rig.hand.configure();
  return configured ? std::string("configured") : configured.error().text();
}

/// When the host first said `byte0` to node `id`.
hal::Timestamp first(const FakeHand& fake, int id, int byte0) {
  for (std::size_t i = 0; i < fake.from_host.size(); ++i)
    if (fake.from_host[i].id == id && fake.from_host[i].data[0] == byte0 && fake.from_host[i].length > 0)
      return fake.said_at[i];
  return hal::Timestamp::max();
}

}  // namespace

TEST_CASE("a hand just switched on is woken, left in peace, known, and opened to its stops",
          "[hand][startup]") {
  HandRig rig;
  rig.fake.pucks[0].position = 120'000;
  rig.fake.pucks[3].position = 20'000;
  rig.start();
  const auto state = rig.look();
  CHECK_FALSE(state.moving);
  CHECK_FALSE(state.held);
  for (const double angle : state.finger_rad) CHECK(std::abs(angle) < 0.01);
  CHECK(std::abs(state.spread_rad) < 0.01);
  CHECK(state.torque_nm[0] == Approx(0.0).margin(0.01));
  CHECK(state.tip_force_n[2] == Approx(0.0));
  CHECK(rig.hand.health().state == hal::DeviceHealth::State::Streaming);
  CHECK(rig.hand.health().last_error.empty());

  // nobody is spoken to while the pucks boot
  const hal::Timestamp woken = first(rig.fake, 14, 0x85);
  for (const hal::Timestamp at : rig.fake.said_at) CHECK_FALSE((at > woken && at < woken + 1s));
  // fingers first: the spread starts when all of them have arrived
  CHECK(first(rig.fake, 11, 0x9d) > woken + 1s);
  CHECK(first(rig.fake, 14, 0x9d) > first(rig.fake, 13, 0x9d) + 1600ms);
}

TEST_CASE("pucks that listen to another group are told to join, in RAM only", "[hand][startup]") {
  HandRig rig;
  for (FakePuck& puck : rig.fake.pucks) puck.property[28] = 8;
  rig.start();
  for (const FakePuck& puck : rig.fake.pucks) CHECK(puck.property[28] == 5);
  for (std::size_t p = 0; p < 4; ++p) CHECK(rig.fake.sets(p, 30) == 0);  // SAVE
  const std::size_t from = rig.fake.from_host.size();
  rig.pass(100ms);
  int group = 0;
  for (std::size_t i = from; i < rig.fake.from_host.size(); ++i) group += rig.fake.from_host[i].id == 0x405;
  CHECK(group >= 10);
}

TEST_CASE("a hand that another program left initialised is not moved", "[hand][startup]") {
  HandRig rig;
  rig.start();
  rig.pass(100ms);
  rig.hand.deactivate();
  const std::size_t from = rig.fake.from_host.size();
  hal::BarrettHand next(*rig.fake.host, {}, rig.clock);
  REQUIRE(next.configure());
  for (std::size_t p = 0; p < 4; ++p) CHECK(rig.fake.sets(p, 29, from) == 0);
}

TEST_CASE("closed fingers of an earlier program may hold something: only release opens them",
          "[hand][startup]") {
  HandRig rig;
  rig.start();
  rig.grip();
  const double held_at = rig.fake.pucks[0].position;
  hal::BarrettHand next(*rig.fake.host, {}, rig.clock);  // the first one was killed
  REQUIRE(next.configure());
  REQUIRE(next.activate());
  CHECK(rig.fake.pucks[0].position == Approx(held_at).margin(200));
  const auto refused = next.preshape(0.0);
  REQUIRE_FALSE(refused);
  CHECK(refused.error().code == ErrorCode::NotReady);
  REQUIRE(next.release());
  rig.fake.pass(3s, [&] { (void)next.state(); });
  CHECK(rig.fake.pucks[0].position < 1000);
  CHECK(next.preshape(0.0));
}

TEST_CASE("a hand that may not look for its zero says so", "[hand][startup]") {
  hal::BarrettHandConfig config;
  config.initialise = "never";
  HandRig rig(config);
  CHECK_THAT(failure_of(rig), Contains("does not know its zero"));
  for (std::size_t p = 0; p < 4; ++p) CHECK(rig.fake.sets(p, 29) == 0);
}

TEST_CASE("what a failed start means is said in words", "[hand][startup]") {
  HandRig rig;
  SECTION("no power: nobody acknowledges") {
    for (FakePuck& puck : rig.fake.pucks) puck.silent = true;
    rig.fake.bus.tap = [&](const hal::CanFrame&) { rig.fake.host->note_not_acknowledged(); };
    CHECK_THAT(failure_of(rig), Contains("nobody on the bus acknowledges") && Contains("supply on"));
  }
  SECTION("wrong bit rate, or no termination") {
    for (FakePuck& puck : rig.fake.pucks) puck.silent = true;
    rig.fake.bus.tap = [&](const hal::CanFrame&) { rig.fake.host->note_bus_error(); };
    CHECK_THAT(failure_of(rig), Contains("1 Mbit/s") && Contains("termination"));
  }
  SECTION("an empty bus") {
    for (FakePuck& puck : rig.fake.pucks) puck.silent = true;
    CHECK_THAT(failure_of(rig), Contains("the bus reports no errors") && Contains("is this its bus"));
  }
  SECTION("silence behind a gateway that reports no errors") {
    for (FakePuck& puck : rig.fake.pucks) puck.silent = true;
    rig.fake.host->hide_errors();
    CHECK_THAT(failure_of(rig),
               Contains("not known") && Contains("-e 1FFFFFFF") && !Contains("reports no errors"));
  }
  SECTION("one silent puck") {
    rig.fake.pucks[1].silent = true;
    CHECK_THAT(failure_of(rig), Contains("F1, F3, spread answer, F2 is silent"));
  }
  SECTION("bus-off while asking") {
    for (FakePuck& puck : rig.fake.pucks) puck.silent = true;
    rig.fake.bus.tap = [&](const hal::CanFrame&) { rig.fake.host->be(hal::CanHealth::State::BusOff); };
    CHECK_THAT(failure_of(rig), Contains("nobody on the bus acknowledges"));
  }
  SECTION("interface down") {
    rig.fake.host->set_down(true);
    const auto configured = rig.hand.configure();
    REQUIRE_FALSE(configured);
    CHECK(configured.error().code == ErrorCode::LinkLost);
    CHECK_THAT(configured.error().text(), Contains("interface is down"));
  }
  SECTION("a puck in error") {
    rig.fake.pucks[2].stat = 1;
    rig.fake.pucks[2].property[4] = 37;
    CHECK_THAT(failure_of(rig), Contains("F3 reports an error (code 37)"));
  }
  SECTION("another product on the bus") {
    rig.fake.pucks[0].property[1] = 0x1600;
    CHECK_THAT(failure_of(rig), Contains("no puck of a BarrettHand"));
  }
  SECTION("old firmware") {
    rig.fake.pucks[0].property[0] = 118;
    CHECK_THAT(failure_of(rig), Contains("firmware 118"));
  }
  SECTION("a finger that does not find its stop") {
    rig.fake.pucks[1].position = 90'000;
    rig.fake.pucks[1].stuck = true;
    CHECK_THAT(failure_of(rig), Contains("F2 did not find its stop within 10 s"));
  }
  SECTION("a clock that stands still ends the waiting") {
    hal::ManualClock frozen;
    sim_hal::MemoryCan bus(frozen);
    const auto node = bus.node();
    hal::BarrettHand hand(*node, {}, frozen);
    CHECK_FALSE(hand.configure());
  }
  CHECK(rig.hand.state().error().code == ErrorCode::NotReady);
  CHECK_FALSE(rig.hand.activate());
}

TEST_CASE("a tactile pad that did not start is left alone, and said", "[hand][startup]") {
  HandRig rig;
  rig.fake.pucks[1].property[107] = -2;
  rig.start();
  rig.pass(100ms);
  CHECK(std::isnan(rig.look().tip_force_n[1]));
  CHECK_FALSE(std::isnan(rig.look().tip_force_n[0]));
  CHECK_THAT(rig.hand.health().last_error, Contains("tactile pad of F2"));
}

TEST_CASE("a hand without gauges and pads works, and says that it has none", "[hand][startup]") {
  HandRig rig;
  for (FakePuck& puck : rig.fake.pucks) puck.property[1] = 0x0605;
  rig.start();
  CHECK(std::isnan(rig.look().torque_nm[0]));
  CHECK(std::isnan(rig.look().tip_force_n[0]));
  rig.grip();
}
