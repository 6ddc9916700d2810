// A clutch that does not come back where it gave way: the outer link stays ahead of the open finger.
#include "hand_rig.hpp"

using namespace colift;
using namespace std::chrono_literals;
using Catch::Matchers::Contains;

namespace {

constexpr double kAhead = 12'000.0;  // counts of the motor: 14 degrees of the outer link; 9500 are breakaway

}  // namespace

TEST_CASE("a finger that opening leaves broken away is named, and is whole once it was initialised",
          "[hand]") {
  HandRig rig;
  rig.start();
  rig.grip();
  rig.fake.pucks[1].clutch_ahead = kAhead;
  rig.pass(100ms);
  REQUIRE(rig.hand.report().broken_away[1]);
  REQUIRE(rig.hand.release());
  const auto open = rig.settle();
  CHECK_FALSE(open.held);
  CHECK(rig.hand.report().broken_away[1]);
  CHECK_THAT(rig.why(), Contains("F2 is still broken away after opening") && Contains("initialised anew"));
  // the motor is at its stop, so the outer link is what the encoders differ by
  CHECK(open.outer_rad[1] == Approx(kAhead * (1.0 / 32594.93 / 2.5)).margin(1e-3));

  rig.hand.deactivate();
  hal::BarrettHandConfig config;
  config.initialise = "always";
  hal::BarrettHand next(*rig.fake.host, config, rig.clock);
  REQUIRE(next.configure());
  rig.fake.pass(100ms, [&] { (void)next.state(); });
  CHECK_FALSE(next.report().broken_away[1]);
  const auto state = next.state();
  REQUIRE(state);
  CHECK(std::abs(state->finger_rad[1]) < 0.01);
  CHECK(std::abs(state->outer_rad[1]) < 0.01);
}

TEST_CASE("a little play behind an open finger is no breakaway", "[hand]") {
  HandRig rig;
  rig.start();
  rig.grip();
  rig.fake.pucks[1].clutch_ahead = 9'000.0;
  REQUIRE(rig.hand.release());
  (void)rig.settle();
  CHECK_FALSE(rig.hand.report().broken_away[1]);
  CHECK(rig.why().empty());
}
