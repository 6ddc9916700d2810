#include <algorithm>
#include <catch2/catch.hpp>
#include <chrono>
#include <limits>
#include <memory>
#include <vector>

#include "barrett_rig.hpp"
#include "barrett_wire_rig.hpp"
#include "hal/guards/guarded_hand.hpp"
#include "sim_hal/mock/mock_hand.hpp"
#include "sim_rig.hpp"

namespace colift {
namespace {

using namespace std::chrono_literals;
using hal::ErrorCode;

sim_hal::HandScript script(bool with_object) {
  sim_hal::HandScript s;
  if (with_object) s.contact_rad = [](hal::Timestamp) { return sim_hal::FingerAngles{1.2, 1.2, 1.18}; };
  return s;
}

// A hand with something between its fingers, or with nothing, and what moves time for it.
struct MockRig {
  explicit MockRig(bool with_object)
      : hand(std::make_unique<sim_hal::MockHand>(script(with_object), clock)) {}
  void pass(hal::Duration by) { clock.advance(by); }
  hal::ManualClock clock;
  std::unique_ptr<hal::Hand> hand;
};

struct SimRig {
  explicit SimRig(bool with_object)
      : world(contract_world(with_object)), hand(sim_hal::make_sim_hand(*world)) {}
  void pass(hal::Duration by) { world->advance(by); }
  std::unique_ptr<sim_hal::SimWorld> world;
  std::unique_ptr<hal::Hand> hand;
};

struct GuardedMockRig {
  explicit GuardedMockRig(bool with_object)
      : hand(std::make_unique<hal::GuardedHand>(
            std::make_unique<sim_hal::MockHand>(script(with_object), clock), hal::HandGuardConfig{})) {}
  void pass(hal::Duration by) { clock.advance(by); }
  hal::ManualClock clock;
  std::unique_ptr<hal::Hand> hand;
};

constexpr double kStill_rad = 0.02;

hal::HandState look(hal::Hand& hand) {
  const auto state = hand.state();
  REQUIRE(state);
  return *state;
}

/// Lets time pass until the hand is at rest; at most 8 s.
template <class Rig>
hal::HandState settle(Rig& rig) {
  for (int i = 0; i < 160 && look(*rig.hand).moving; ++i) rig.pass(50ms);
  const auto state = look(*rig.hand);
  CHECK_FALSE(state.moving);
  return state;
}

template <class Rig>
void activate(Rig& rig) {
  REQUIRE(rig.hand->configure());
  REQUIRE(rig.hand->activate());
}

double furthest(const std::array<double, hal::kFingers>& a, const std::array<double, hal::kFingers>& b) {
  double most = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) most = std::max(most, std::abs(a[i] - b[i]));
  return most;
}

}  // namespace

#ifdef COLIFT_CONTRACT_ON_VCAN  // in a machine whose kernel has CAN: tests/can_vm
#define COLIFT_HANDS SocketcanRig
#else
#define COLIFT_HANDS MockRig, SimRig, BarrettRig, SocketcandRig, GuardedMockRig
#endif

TEMPLATE_TEST_CASE("a hand tells nothing and does nothing before it is ready", "[hand][contract]",
                   COLIFT_HANDS) {
  TestType rig(false);
  const auto state = rig.hand->state();
  REQUIRE_FALSE(state);
  CHECK(state.error().code == ErrorCode::NotReady);
  const auto active = rig.hand->activate();
  REQUIRE_FALSE(active);
  CHECK(active.error().code == ErrorCode::NotReady);
  CHECK_FALSE(rig.hand->close(0.5));
  REQUIRE(rig.hand->configure());
  const auto closed = rig.hand->close(0.5);
  REQUIRE_FALSE(closed);
  CHECK(closed.error().code == ErrorCode::NotReady);
  CHECK_FALSE(rig.hand->release());
  rig.pass(1s);
  REQUIRE(rig.hand->activate());
  const auto still = look(*rig.hand);
  CHECK_FALSE(still.moving);
  CHECK_FALSE(still.held);
  for (const double angle : still.finger_rad) CHECK(std::abs(angle) < kStill_rad);
}

TEMPLATE_TEST_CASE("preshape opens the fingers and turns the spread", "[hand][contract]", COLIFT_HANDS) {
  TestType rig(false);
  activate(rig);
  REQUIRE(rig.hand->preshape(0.5));
  rig.pass(50ms);
  CHECK(look(*rig.hand).moving);
  const auto state = settle(rig);
  CHECK(state.spread_rad == Approx(0.5).margin(0.03));
  for (const double angle : state.finger_rad) CHECK(std::abs(angle) < kStill_rad);
  CHECK_FALSE(state.held);
}

TEMPLATE_TEST_CASE("closing around something ends held, and says that it moves on the way",
                   "[hand][contract]", COLIFT_HANDS) {
  TestType rig(true);
  activate(rig);
  REQUIRE(rig.hand->close(0.8));
  CHECK_FALSE(look(*rig.hand).held);
  rig.pass(200ms);
  const auto under_way = look(*rig.hand);
  CHECK(under_way.moving);
  CHECK_FALSE(under_way.held);
  const auto state = settle(rig);
  CHECK(state.held);
  for (const double angle : state.finger_rad) {
    CHECK(angle > 0.5);
    CHECK(angle < 2.0);
  }
  // and stays so with no more calls
  rig.pass(2s);
  const auto later = look(*rig.hand);
  CHECK(later.held);
  CHECK(furthest(later.finger_rad, state.finger_rad) < kStill_rad);
}

TEMPLATE_TEST_CASE("closing around nothing ends at the stops and holds nothing", "[hand][contract]",
                   COLIFT_HANDS) {
  TestType rig(false);
  activate(rig);
  REQUIRE(rig.hand->close(0.8));
  const auto state = settle(rig);
  CHECK_FALSE(state.held);
  for (const double angle : state.finger_rad) CHECK(angle > 1.5);
}

TEMPLATE_TEST_CASE("a hand that holds refuses to preshape, and release alone opens it", "[hand][contract]",
                   COLIFT_HANDS) {
  TestType rig(true);
  activate(rig);
  REQUIRE(rig.hand->close(0.8));
  const auto held = settle(rig);
  REQUIRE(held.held);
  const auto refused = rig.hand->preshape(0.0);
  REQUIRE_FALSE(refused);
  CHECK(refused.error().code == ErrorCode::NotReady);
  rig.pass(1s);
  CHECK(look(*rig.hand).held);
  CHECK(furthest(look(*rig.hand).finger_rad, held.finger_rad) < kStill_rad);

  REQUIRE(rig.hand->release());
  rig.pass(100ms);
  CHECK_FALSE(look(*rig.hand).held);
  const auto open = settle(rig);
  for (const double angle : open.finger_rad) CHECK(std::abs(angle) < 2 * kStill_rad);
  CHECK(rig.hand->preshape(0.0));
}

TEMPLATE_TEST_CASE("a hand that is stopped stays where it is, and can be closed again", "[hand][contract]",
                   COLIFT_HANDS) {
  TestType rig(true);
  rig.hand->stop();
  activate(rig);
  REQUIRE(rig.hand->close(0.8));
  rig.pass(300ms);
  for (int i = 0; i < 3; ++i) rig.hand->stop();
  rig.pass(200ms);
  const auto state = look(*rig.hand);
  CHECK_FALSE(state.moving);
  CHECK_FALSE(state.held);
  CHECK(state.finger_rad[0] > 0.05);
  rig.pass(2s);
  CHECK(furthest(look(*rig.hand).finger_rad, state.finger_rad) < kStill_rad);
  REQUIRE(rig.hand->close(0.8));
  CHECK(settle(rig).held);
}

TEMPLATE_TEST_CASE("a loaded hand stays closed when it is stopped or deactivated", "[hand][contract]",
                   COLIFT_HANDS) {
  TestType rig(true);
  activate(rig);
  REQUIRE(rig.hand->close(0.8));
  const auto held = settle(rig);
  REQUIRE(held.held);
  rig.hand->stop();
  rig.pass(500ms);
  rig.hand->deactivate();
  rig.hand->deactivate();
  rig.pass(2s);
  CHECK_FALSE(rig.hand->release());
  REQUIRE(rig.hand->activate());
  CHECK(look(*rig.hand).held);
  CHECK(furthest(look(*rig.hand).finger_rad, held.finger_rad) < kStill_rad);
}

TEMPLATE_TEST_CASE("requests beyond what a hand can do are refused and start nothing", "[hand][contract]",
                   COLIFT_HANDS) {
  TestType rig(false);
  activate(rig);
  const double nan = std::numeric_limits<double>::quiet_NaN(), inf = std::numeric_limits<double>::infinity();
  for (const double torque : {nan, inf, -inf, -0.5, 0.0, 50.0}) {
    const auto refused = rig.hand->close(torque);
    REQUIRE_FALSE(refused);
    CHECK(refused.error().code == ErrorCode::LimitExceeded);
  }
  for (const double spread : {nan, inf, -0.1, 3.3}) {
    const auto refused = rig.hand->preshape(spread);
    REQUIRE_FALSE(refused);
    CHECK(refused.error().code == ErrorCode::LimitExceeded);
  }
  rig.pass(100ms);
  CHECK_FALSE(look(*rig.hand).moving);
}

TEMPLATE_TEST_CASE("a hand's states are plausible, in the order of time, and the same for the same calls",
                   "[hand][contract]", COLIFT_HANDS) {
  const auto run = [] {
    TestType rig(true);
    activate(rig);
    REQUIRE(rig.hand->close(0.8));
    std::vector<hal::HandState> states;
    for (int i = 0; i < 60; ++i) {
      rig.pass(50ms);
      states.push_back(look(*rig.hand));
    }
    return states;
  };
  const auto one = run(), other = run();
  for (std::size_t i = 0; i < one.size(); ++i) {
    if (i > 0) CHECK(one[i].measured_at > one[i - 1].measured_at);
    for (std::size_t f = 0; f < hal::kFingers; ++f) {
      CHECK(one[i].finger_rad[f] >= -kStill_rad);
      CHECK(one[i].finger_rad[f] <= 2.44 + kStill_rad);
      CHECK(one[i].outer_rad[f] >= one[i].finger_rad[f] / 3.0 - kStill_rad);
    }
    CHECK(one[i].measured_at == other[i].measured_at);
    CHECK(one[i].finger_rad == other[i].finger_rad);
    CHECK(one[i].held == other[i].held);
  }
}

}  // namespace colift
