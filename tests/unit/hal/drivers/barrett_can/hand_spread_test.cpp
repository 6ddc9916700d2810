// The spread under load: the only axis without a worm gear.
#include "hand_rig.hpp"

using namespace colift;
using namespace std::chrono_literals;
using Catch::Matchers::Contains;

namespace {
constexpr double kCounts_deg = 17.5 * 4096.0 / 360.0;
}

TEST_CASE("a spread that a load turns is a slip, with its angle", "[hand][spread]") {
  HandRig rig;
  rig.start();
  rig.grip();
  rig.pass(200ms);
  REQUIRE_FALSE(rig.hand.report().slipped);
  FakePuck& spread = rig.fake.pucks[3];
  spread.stuck = true;  // its motor does not turn it back
  const double by_deg = GENERATE(3.0, 50.0);
  // no leap: 100 degrees/s
  for (double turned = 0.0; turned < by_deg; turned += 0.1) {
    spread.position += 0.1 * kCounts_deg;
    rig.pass(1ms);
  }
  rig.pass(50ms);
  CAPTURE(by_deg, rig.why());
  const bool given_way = by_deg > 10.0;
  CHECK(rig.hand.report().slipped == given_way);
  CHECK(rig.look().slips == given_way);
  CHECK((rig.why().find("the spread turned by") == 0) == given_way);
  CHECK(rig.look().held);
  REQUIRE(rig.hand.release());
  rig.pass(10ms);
  CHECK_FALSE(rig.hand.report().slipped);
}

TEST_CASE("it is noticed within 60 ms that the spread turned too far", "[hand][spread]") {
  HandRig rig;
  rig.start();
  rig.grip();
  rig.pass(200ms);
  rig.fake.pucks[3].stuck = true;
  double turned = 0.0;
  hal::Timestamp beyond{0};
  (void)until(rig, 1s, [&] {
    turned += 0.1;
    rig.fake.pucks[3].position += 0.1 * kCounts_deg;
    if (turned > 5.8 && beyond == hal::Timestamp{0}) beyond = rig.clock.now();
    return rig.hand.report().slipped;
  });
  CHECK(rig.clock.now() - beyond <= 60ms);
}

TEST_CASE("a loaded spread that lets go of its angle is a fault: nothing else keeps it", "[hand][spread]") {
  HandRig rig;
  rig.start();
  rig.grip();
  rig.pass(200ms);
  rig.fake.pucks[3].property[8] = 0;
  const auto lost = [&] {
    const auto state = rig.hand.state();
    return !state && state.error().code == hal::ErrorCode::DeviceFault;
  };
  CHECK(until(rig, 300ms, lost) <= 150ms);
  CHECK_THAT(rig.hand.state().error().detail, Contains("nothing keeps its angle"));
  // an open hand's spread may rest
  REQUIRE(rig.hand.release());
  rig.pass(2s);
  CHECK(rig.hand.state());
}
