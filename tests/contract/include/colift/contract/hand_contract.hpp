#pragma once

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <functional>
#include <limits>
#include <memory>
#include <vector>

#include "colift/contract/catch.hpp"
#include "hal/hand.hpp"

namespace colift::contract {

/// A hand under test, ready to be configured, and what lets time pass for it.
struct HandUnderTest {
  std::shared_ptr<void> rig;  ///< Owns the hand and what it needs to live: clock, far end, world.
  hal::Hand* hand = nullptr;
  std::function<void(hal::Duration)> pass;  ///< Moves simulated time, or waits on a real device.
};

/// Makes one, with something between its fingers that they can grip, or with nothing; called anew for each
/// fact.
using MakeHand = std::function<HandUnderTest(bool with_object)>;

/// What the suite has to know about a hand. Angles in rad, torques in N m.
struct HandTraits {
  double tolerance_rad = 0.02;                    ///< Of a finger that is at rest.
  double closed_rad = 2.44;                       ///< Inner joint at its stop.
  double torque_nm = 0.8;                         ///< With which it closes in the tests.
  double max_spread_rad = 3.3;                    ///< No hand turns its spread so far.
  double impossible_nm = 50.0;                    ///< No hand is as strong.
  double held_from_rad = 0.5, held_to_rad = 2.0;  ///< Where fingers rest on the object.
  bool repeatable = true;                         ///< The same calls on a new hand give the same states.
};

namespace detail {

inline hal::HandState state_of(hal::Hand& hand) {
  const auto state = hand.state();
  REQUIRE(state);
  return *state;
}

/// Lets time pass until the hand is at rest; at most 8 s.
inline hal::HandState settle(const HandUnderTest& test) {
  for (int i = 0; i < 160 && state_of(*test.hand).moving; ++i) test.pass(std::chrono::milliseconds(50));
  const auto state = state_of(*test.hand);
  CHECK_FALSE(state.moving);
  return state;
}

inline void activate(const HandUnderTest& test) {
  REQUIRE(test.hand->configure());
  REQUIRE(test.hand->activate());
}

inline hal::HandState close_and_settle(const HandUnderTest& test, double torque_nm) {
  REQUIRE(test.hand->close(torque_nm));
  return settle(test);
}

using FingerAngles = std::array<double, hal::kFingers>;

inline double max_difference(const FingerAngles& a, const FingerAngles& b) {
  double most = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) most = std::max(most, std::abs(a[i] - b[i]));
  return most;
}

inline std::vector<hal::HandState> states_while_closing(const MakeHand& make, double torque_nm) {
  const HandUnderTest test = make(true);
  activate(test);
  REQUIRE(test.hand->close(torque_nm));
  std::vector<hal::HandState> states;
  for (int i = 0; i < 60; ++i) {
    test.pass(std::chrono::milliseconds(50));
    states.push_back(state_of(*test.hand));
  }
  return states;
}

}  // namespace detail

/// What every hal::Hand promises (hal/hand.hpp, hal/device.hpp), one section for each fact. To be called from
/// a test case of its own, as contract::check_arm(). Opens and closes the hand some ten times.
inline void check_hand(const MakeHand& make, const HandTraits& traits = {}) {
  using hal::ErrorCode;
  using std::chrono::milliseconds;
  using std::chrono::seconds;

  SECTION("a hand reports nothing and does nothing before it is ready") {
    const HandUnderTest test = make(false);
    const auto state = test.hand->state();
    REQUIRE_FALSE(state);
    CHECK(state.error().code == ErrorCode::NotReady);
    const auto active = test.hand->activate();
    REQUIRE_FALSE(active);
    CHECK(active.error().code == ErrorCode::NotReady);
    CHECK_FALSE(test.hand->close(0.5));
    REQUIRE(test.hand->configure());
    const auto closed = test.hand->close(0.5);
    REQUIRE_FALSE(closed);
    CHECK(closed.error().code == ErrorCode::NotReady);
    CHECK_FALSE(test.hand->release());
    test.pass(seconds(1));
    REQUIRE(test.hand->activate());
    const auto still = detail::state_of(*test.hand);
    CHECK_FALSE(still.moving);
    CHECK_FALSE(still.held);
    for (const double angle : still.finger_rad) CHECK(std::abs(angle) < traits.tolerance_rad);
  }

  SECTION("preshape opens the fingers and turns the spread") {
    const HandUnderTest test = make(false);
    detail::activate(test);
    REQUIRE(test.hand->preshape(0.5));
    test.pass(milliseconds(50));
    CHECK(detail::state_of(*test.hand).moving);
    const auto state = detail::settle(test);
    CHECK(std::abs(state.spread_rad - 0.5) < 0.03);
    for (const double angle : state.finger_rad) CHECK(std::abs(angle) < traits.tolerance_rad);
    CHECK_FALSE(state.held);
  }

  SECTION("closing around something ends held, and reports motion until then") {
    const HandUnderTest test = make(true);
    detail::activate(test);
    REQUIRE(test.hand->close(traits.torque_nm));
    CHECK_FALSE(detail::state_of(*test.hand).held);
    test.pass(milliseconds(200));
    const auto closing = detail::state_of(*test.hand);
    CHECK(closing.moving);
    CHECK_FALSE(closing.held);
    const auto state = detail::settle(test);
    CHECK(state.held);
    for (const double angle : state.finger_rad) {
      CHECK(angle > traits.held_from_rad);
      CHECK(angle < traits.held_to_rad);
    }
    // and stays so with no more calls
    test.pass(seconds(2));
    const auto later = detail::state_of(*test.hand);
    CHECK(later.held);
    CHECK(detail::max_difference(later.finger_rad, state.finger_rad) < traits.tolerance_rad);
  }

  SECTION("closing around nothing ends at the stops and holds nothing") {
    const HandUnderTest test = make(false);
    detail::activate(test);
    const auto state = detail::close_and_settle(test, traits.torque_nm);
    CHECK_FALSE(state.held);
    for (const double angle : state.finger_rad) CHECK(angle > 0.6 * traits.closed_rad);
  }

  SECTION("a hand that holds refuses to preshape, and release alone opens it") {
    const HandUnderTest test = make(true);
    detail::activate(test);
    const auto held = detail::close_and_settle(test, traits.torque_nm);
    REQUIRE(held.held);
    const auto refused = test.hand->preshape(0.0);
    REQUIRE_FALSE(refused);
    CHECK(refused.error().code == ErrorCode::NotReady);
    test.pass(seconds(1));
    CHECK(detail::state_of(*test.hand).held);
    CHECK(detail::max_difference(detail::state_of(*test.hand).finger_rad, held.finger_rad) <
          traits.tolerance_rad);

    REQUIRE(test.hand->release());
    test.pass(milliseconds(100));
    CHECK_FALSE(detail::state_of(*test.hand).held);
    const auto open = detail::settle(test);
    for (const double angle : open.finger_rad) CHECK(std::abs(angle) < 2 * traits.tolerance_rad);
    CHECK(test.hand->preshape(0.0));
  }

  SECTION("a hand that is stopped stays where it is, and can be closed again") {
    const HandUnderTest test = make(true);
    test.hand->stop();
    detail::activate(test);
    REQUIRE(test.hand->close(traits.torque_nm));
    test.pass(milliseconds(300));
    for (int i = 0; i < 3; ++i) test.hand->stop();
    test.pass(milliseconds(200));
    const auto state = detail::state_of(*test.hand);
    CHECK_FALSE(state.moving);
    CHECK_FALSE(state.held);
    CHECK(state.finger_rad[0] > 0.05);
    test.pass(seconds(2));
    CHECK(detail::max_difference(detail::state_of(*test.hand).finger_rad, state.finger_rad) <
          traits.tolerance_rad);
    CHECK(detail::close_and_settle(test, traits.torque_nm).held);
  }

  SECTION("a loaded hand stays closed when it is stopped or deactivated") {
    const HandUnderTest test = make(true);
    detail::activate(test);
    const auto held = detail::close_and_settle(test, traits.torque_nm);
    REQUIRE(held.held);
    test.hand->stop();
    test.pass(milliseconds(500));
    test.hand->deactivate();
    test.hand->deactivate();
    test.pass(seconds(2));
    CHECK_FALSE(test.hand->release());
    REQUIRE(test.hand->activate());
    CHECK(detail::state_of(*test.hand).held);
    CHECK(detail::max_difference(detail::state_of(*test.hand).finger_rad, held.finger_rad) <
          traits.tolerance_rad);
  }

  SECTION("requests beyond what a hand can do are refused and start nothing") {
    const HandUnderTest test = make(false);
    detail::activate(test);
    const double nan = std::numeric_limits<double>::quiet_NaN(),
                 inf = std::numeric_limits<double>::infinity();
    for (const double torque_nm : {nan, inf, -inf, -0.5, 0.0, traits.impossible_nm}) {
      const auto refused = test.hand->close(torque_nm);
      REQUIRE_FALSE(refused);
      CHECK(refused.error().code == ErrorCode::LimitExceeded);
    }
    for (const double spread_rad : {nan, inf, -0.1, traits.max_spread_rad}) {
      const auto refused = test.hand->preshape(spread_rad);
      REQUIRE_FALSE(refused);
      CHECK(refused.error().code == ErrorCode::LimitExceeded);
    }
    test.pass(milliseconds(100));
    CHECK_FALSE(detail::state_of(*test.hand).moving);
  }

  SECTION("a hand's states are plausible and in the order of time") {
    const auto states = detail::states_while_closing(make, traits.torque_nm);
    for (std::size_t i = 0; i < states.size(); ++i) {
      if (i > 0) CHECK(states[i].measured_at > states[i - 1].measured_at);
      for (std::size_t f = 0; f < hal::kFingers; ++f) {
        CHECK(states[i].finger_rad[f] >= -traits.tolerance_rad);
        CHECK(states[i].finger_rad[f] <= traits.closed_rad + traits.tolerance_rad);
        CHECK(states[i].outer_rad[f] >= states[i].finger_rad[f] / 3.0 - traits.tolerance_rad);
      }
    }
  }

  SECTION(
      "a hand's tactile cells are pressures of its own time, or NaN, and agree with the forces on its pads") {
    for (const auto& state : detail::states_while_closing(make, traits.torque_nm))
      for (std::size_t a = 0; a < state.tactile.size(); ++a) {
        const auto& array = state.tactile[a];
        const double force_n = a < hal::kFingers ? state.tip_force_n[a] : state.palm_force_n;
        double most = 0.0;
        const bool known = array.measured_at != hal::Timestamp{0};
        for (const float cell : array.pressure_n_cm2) {
          CHECK(std::isnan(cell) == !known);
          if (known) CHECK((cell >= 0.0F && cell < 1000.0F));
          most = std::max<double>(most, cell);
        }
        if (!known) continue;
        CHECK(array.measured_at <= state.measured_at + milliseconds(50));
        CHECK((force_n > 0.0) == (most > 0.0));
      }
  }

  if (!traits.repeatable) return;
  SECTION("the same calls give the same states of a hand") {
    const auto one = detail::states_while_closing(make, traits.torque_nm);
    const auto other = detail::states_while_closing(make, traits.torque_nm);
    for (std::size_t i = 0; i < one.size(); ++i) {
      CHECK(one[i].measured_at == other[i].measured_at);
      CHECK(one[i].finger_rad == other[i].finger_rad);
      CHECK(one[i].held == other[i].held);
    }
  }
}

}  // namespace colift::contract
