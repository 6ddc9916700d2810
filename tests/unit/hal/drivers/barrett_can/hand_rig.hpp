#pragma once

#include <catch2/catch.hpp>
#include <cmath>
#include <string>

#include "fake_pucks.hpp"
#include "hal/drivers/barrett_can/barrett_hand.hpp"

namespace colift {

/// A driver on four pucks; polled every millisecond of their time.
struct HandRig {
  hal::ManualClock clock;
  FakeHand fake{clock};
  hal::BarrettHandConfig config;
  hal::BarrettHand hand;

  explicit HandRig(const hal::BarrettHandConfig& c = {}) : config(c), hand(*fake.host, c, clock) {}

  /// Wakes, initialises and activates.
  void start() {
    const auto configured = hand.configure();
    INFO((configured ? std::string() : configured.error().text()));
    REQUIRE(configured);
    REQUIRE(hand.activate());
  }

  void pass(hal::Duration by) {
    fake.pass(by, [this] { (void)hand.state(); });
  }

  hal::HandState look() {
    const auto state = hand.state();
    INFO((state ? std::string() : state.error().text()));
    REQUIRE(state);
    return *state;
  }

  hal::HandState settle() {
    for (int i = 0; i < 800 && look().moving; ++i) pass(std::chrono::milliseconds(10));
    const auto state = look();
    REQUIRE_FALSE(state.moving);
    return state;
  }

  /// Something that all fingers meet at this angle of their inner links.
  void put_object(double rad) {
    for (std::size_t f = 0; f < 3; ++f) fake.pucks[f].blocked_at = rad * 81487.33;
  }

  void grip() {
    put_object(1.2);
    REQUIRE(hand.close(0.75));
    REQUIRE(settle().held);
  }

  [[nodiscard]] std::string why() const { return hand.report().why.str(); }
};

/// The time until `fact` holds, polled every millisecond; a failure after `limit`.
template <class Fact>
hal::Duration until(HandRig& rig, hal::Duration limit, Fact fact) {
  const hal::Timestamp start = rig.clock.now();
  while (!fact()) {
    REQUIRE(rig.clock.now() - start < limit);
    rig.pass(std::chrono::milliseconds(1));
  }
  return rig.clock.now() - start;
}

}  // namespace colift
