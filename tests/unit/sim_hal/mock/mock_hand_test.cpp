#include "sim_hal/mock/mock_hand.hpp"

#include <catch2/catch.hpp>
#include <cmath>

using namespace colift;
using namespace colift::sim_hal;
using hal::ErrorCode;
using Fault = MockHand::Fault;
using std::chrono::milliseconds;

namespace {

constexpr double kNothing = std::numeric_limits<double>::infinity();

struct Rig {
  hal::ManualClock clock;
  MockHand hand;
  explicit Rig(FingerAngles contact) : hand(script(contact), clock) {
    REQUIRE(hand.configure());
    REQUIRE(hand.activate());
  }
  static HandScript script(FingerAngles contact) {
    HandScript s;
    s.contact_rad = [contact](hal::Timestamp) { return contact; };
    return s;
  }
  hal::HandState after(int ms) {
    clock.advance(milliseconds(ms));
    return hand.state().value();
  }
};

}  // namespace

TEST_CASE("fingers of a mock hand move at their speed and rest on what they meet", "[mock][hand]") {
  Rig rig({1.0, 1.2, 0.8});
  REQUIRE(rig.hand.close(0.7));
  const auto in_transit = rig.after(300);
  for (const double angle : in_transit.finger_rad) CHECK(angle == Approx(0.6));
  CHECK(in_transit.moving);
  CHECK(in_transit.outer_rad[0] == Approx(0.2));
  const auto one_there = rig.after(150);
  CHECK(one_there.finger_rad[2] == Approx(0.8));
  CHECK(one_there.torque_nm[2] == 0.7);
  CHECK(one_there.torque_nm[0] == 0.0);
  CHECK_FALSE(one_there.held);
  const auto closed = rig.after(500);
  CHECK(closed.finger_rad == FingerAngles{1.0, 1.2, 0.8});
  CHECK(closed.held);
  CHECK_FALSE(closed.moving);
}

TEST_CASE("a grip needs the thumb and one finger opposite", "[mock][hand]") {
  const auto held = [](FingerAngles contact) {
    Rig rig(contact);
    REQUIRE(rig.hand.close(0.5));
    return rig.after(3000).held;
  };
  CHECK(held({1.0, 1.0, 1.0}));
  CHECK(held({1.0, kNothing, 1.0}));
  CHECK_FALSE(held({1.0, 1.0, kNothing}));
  CHECK_FALSE(held({kNothing, kNothing, 1.0}));
}

TEST_CASE("it does not matter how often a mock hand is looked at", "[mock][hand]") {
  Rig often({1.0, 1.1, 0.9}), once({1.0, 1.1, 0.9});
  REQUIRE(often.hand.close(0.5));
  REQUIRE(once.hand.close(0.5));
  for (int i = 0; i < 37; ++i) (void)often.after(11);
  CHECK(often.hand.state()->finger_rad == once.after(37 * 11).finger_rad);
}

TEST_CASE("each fault of a mock hand shows as it should and passes", "[mock][hand]") {
  Rig rig({kNothing, kNothing, kNothing});
  rig.hand.inject(Fault::Freeze, 10);
  rig.hand.inject(Fault::Drop, 20);
  rig.hand.inject(Fault::Jump, 30);
  rig.hand.inject(Fault::Nan, 40);
  rig.hand.inject(Fault::Late, 50);
  rig.hand.inject(Fault::Unplug, 60, 5);
  const auto before = rig.after(50);
  CHECK(rig.after(50).measured_at == before.measured_at);
  CHECK(rig.after(50).measured_at == milliseconds(150));
  rig.clock.advance(milliseconds(50));
  CHECK(rig.hand.state().error().code == ErrorCode::Timeout);
  CHECK(rig.after(100).finger_rad[1] == 0.5);
  CHECK(std::isnan(rig.after(100).finger_rad[0]));
  CHECK(rig.after(100).measured_at == milliseconds(200));
  rig.clock.advance(milliseconds(100));
  CHECK(rig.hand.close(0.5).error().code == ErrorCode::LinkLost);
  CHECK(rig.hand.state().error().code == ErrorCode::LinkLost);
  CHECK(rig.hand.configure().error().code == ErrorCode::LinkLost);
  rig.clock.advance(milliseconds(50));
  REQUIRE(rig.hand.configure());
  REQUIRE(rig.hand.activate());
  CHECK(rig.hand.state());
}

TEST_CASE("a mock hand that loses its link keeps what it holds", "[mock][hand]") {
  Rig rig({1.0, 1.0, 1.0});
  rig.hand.inject(Fault::Unplug, 200, 10);
  REQUIRE(rig.hand.close(0.5));
  REQUIRE(rig.after(1000).held);
  rig.clock.advance(milliseconds(1000));
  CHECK_FALSE(rig.hand.state());
  rig.clock.advance(milliseconds(1000));
  REQUIRE(rig.hand.configure());
  REQUIRE(rig.hand.activate());
  CHECK(rig.hand.state()->held);
  CHECK(rig.hand.preshape(0.0).error().code == ErrorCode::NotReady);
}
