// Answers that come late: a gateway behind a slow network, a machine that is busy.
#include "hal/drivers/barrett_can/pucks/round_trip.hpp"
#include "hand_rig.hpp"

using namespace colift;
using namespace std::chrono_literals;
using Catch::Matchers::Contains;
using Fate = sim_hal::MemoryCan::Fate;

namespace {

void late(HandRig& rig, hal::Duration by) {
  rig.fake.latency = by;
}

void stays_well(HandRig& rig, hal::Duration for_how_long) {
  const hal::Timestamp end = rig.clock.now() + for_how_long;
  while (rig.clock.now() < end) {
    rig.pass(1ms);
    const auto state = rig.hand.state();
    INFO(hal::seconds(rig.clock.now()) << " s of " << hal::seconds(end));
    INFO((state ? std::string() : state.error().text()));
    REQUIRE(state);
  }
}

}  // namespace

TEST_CASE("a slow link is measured at the start, named, and the hand works over it", "[hand][slow]") {
  const auto by = GENERATE(hal::Duration(20ms), hal::Duration(30ms), hal::Duration(60ms));
  HandRig rig;
  late(rig, by);
  rig.start();
  CAPTURE(by.count() / 1'000'000, rig.hand.report().remark.str());
  CHECK_THAT(rig.hand.report().remark.str(), Contains("slow link"));
  stays_well(rig, 500ms);
  CHECK_THAT(rig.look().warning.str(), Contains("slow link"));
  rig.grip();
  stays_well(rig, 3s);
  CHECK(rig.look().held);
  // what is really silent is still noticed
  rig.fake.pucks[1].silent = true;
  (void)until(rig, 200ms, [&] { return !rig.hand.state(); });  // its positions are old
  (void)until(rig, 1s, [&] {
    const auto state = rig.hand.state();
    return !state && state.error().detail.find("F2 (node 12) is silent") == 0;
  });
}

TEST_CASE("a link that becomes slow is named, and nothing stops for it", "[hand][slow]") {
  const auto by = GENERATE(hal::Duration(12ms), hal::Duration(20ms), hal::Duration(30ms));
  HandRig rig;
  rig.start();
  rig.grip();
  CAPTURE(by.count() / 1'000'000);
  REQUIRE(rig.look().warning.empty());
  late(rig, by);
  stays_well(rig, 1500ms);
  CHECK_THAT(rig.look().warning.str(), Contains("slow link"));
  CHECK(rig.look().held);
  // and is quick again: a silent puck is noticed as quickly as ever
  late(rig, 150us);
  stays_well(rig, 4s);
  CHECK(rig.look().warning.empty());
  rig.fake.pucks[1].silent = true;
  CHECK(until(rig, 200ms, [&] { return !rig.hand.state(); }) <= 50ms);
}

TEST_CASE("an answer that came late is never shown as one in time", "[hand][slow]") {
  for (const auto by : {hal::Duration(1us), hal::Duration(40us), hal::Duration(300us), hal::Duration(12ms)}) {
    hal::barrett::RoundTrip trip(8ms);
    trip.note_answer(8ms + by);
    CHECK(trip.worst_ms() > 8.0);
    CHECK(trip.worst_ms() <= 1e3 * hal::seconds(8ms + by) + 0.1);
  }
}

TEST_CASE("nobody is late while this program did not run", "[hand][slow]") {
  HandRig rig;
  rig.start();
  rig.grip();
  for (int i = 0; i < 40; ++i) {
    rig.fake.pass(hal::Duration(std::chrono::milliseconds(20 + i)));  // the machine was busy
    const auto state = rig.hand.state();
    INFO(i << ": " << (state ? std::string() : state.error().text()));
    if (i > 0) REQUIRE(state);
    rig.pass(3ms);
    REQUIRE(rig.hand.state());
  }
  CHECK(rig.look().held);
  CHECK(rig.look().warning.empty());
}
