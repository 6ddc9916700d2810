// `hal hand state`: what a hand answers, without touching it.
#include "hal/drivers/barrett_can/service/hand_reading.hpp"
#include "hand_rig.hpp"

using namespace colift;
using namespace std::chrono_literals;
using Catch::Matchers::Contains;
using hal::barrett::Property;

TEST_CASE("a cold hand is read and stays cold", "[hand][reading]") {
  HandRig rig;  // just switched on
  const auto reading = hal::read_hand(*rig.fake.host, rig.clock, rig.config);
  REQUIRE(reading);
  CHECK(reading->answering() == 4);
  for (const hal::PuckReading& p : reading->pucks) {
    CHECK_FALSE(p.awake());
    CHECK(p.of(Property::Vers) == 200);
    CHECK(p.of(Property::Stat) == 0);
    CHECK(p.of(Property::Mode) == std::nullopt);  // not asked: the monitor does not answer
  }
  for (const hal::CanFrame& f : rig.fake.from_host) {
    CHECK(f.length == 1);
    CHECK((f.data[0] & 0x80) == 0);  // questions alone
    CHECK(f.data[0] <= 5);
  }
  for (const FakePuck& puck : rig.fake.pucks) CHECK(puck.stat == 0);
}

TEST_CASE("a hand that holds something is read and goes on holding", "[hand][reading]") {
  HandRig rig;
  rig.start();
  rig.grip();
  const std::size_t from = rig.fake.from_host.size();
  const auto reading = hal::read_hand(*rig.fake.host, rig.clock, rig.config);
  REQUIRE(reading);
  for (std::size_t i = from; i < rig.fake.from_host.size(); ++i) CHECK(rig.fake.from_host[i].length == 1);
  const hal::PuckReading& f2 = reading->pucks[1];
  CHECK(f2.of(Property::Mode) == 5);
  CHECK(f2.of(Property::Temp) == 35);
  CHECK(f2.of(Property::Otemp) == 60);
  CHECK(f2.zero_known());
  CHECK(f2.of(Property::P).value_or(0) == Approx(1.2 * 81487.33).margin(300));
  CHECK(f2.joint);
  CHECK_FALSE(reading->pucks[3].joint);
}

TEST_CASE("silent pucks are told, and nobody at all is an error", "[hand][reading]") {
  HandRig rig;
  rig.start();
  rig.fake.pucks[2].silent = true;
  const auto reading = hal::read_hand(*rig.fake.host, rig.clock, rig.config);
  REQUIRE(reading);
  CHECK(reading->answering() == 3);
  CHECK_FALSE(reading->pucks[2].answers);
  for (FakePuck& puck : rig.fake.pucks) puck.silent = true;
  const auto nobody = hal::read_hand(*rig.fake.host, rig.clock, rig.config);
  REQUIRE_FALSE(nobody);
  CHECK(nobody.error().code == hal::ErrorCode::LinkLost);
}

TEST_CASE("a slow link is read as well, and its slowness measured", "[hand][reading]") {
  HandRig rig;
  rig.fake.latency = 60ms;
  const auto reading = hal::read_hand(*rig.fake.host, rig.clock, rig.config);
  REQUIRE(reading);
  CHECK(reading->answering() == 4);
  CHECK(reading->round_trip >= 60ms);
  CHECK(reading->round_trip < 70ms);
}
