// Clutches that gave way under an object deep in the hand: whoever opens the finger brings them back, and no
// zero is lost on the way. On emulated pucks, whose clutch is tight again where it gave way.
#include <catch2/catch.hpp>
#include <cmath>

#include "hal/drivers/barrett_can/emergency_open.hpp"
#include "hal/drivers/barrett_can/service/finger_motion.hpp"
#include "tests/contract/barrett_rig.hpp"

using namespace colift;
using namespace std::chrono_literals;
using hal::barrett::Puck;

namespace {

/// All three fingers hold something with their inner links, and their outer links have gone on.
struct BrokenAway : BarrettRig {
  explicit BrokenAway() : BarrettRig(false) {
    REQUIRE(hand->configure());
    REQUIRE(hand->activate());
    sim_hal::HandObject deep;
    deep.inner_rad.fill(0.8);
    deep.total_rad.fill(1.6);
    plant.put(deep);
    REQUIRE(hand->preshape(1.2));  // no finger presses against another: each has all of the torque
    pass(1500ms);
    REQUIRE(hand->close(0.75));
    pass(2500ms);
    REQUIRE(hand->state()->held);
    for (std::size_t f = 0; f < 3; ++f) REQUIRE(is_broken_away(f));
  }
  /// By the plant, and by both encoders as the driver reads them.
  [[nodiscard]] bool is_broken_away(std::size_t finger) {
    const bool told = driver->report().broken_away[finger];
    CHECK(told == plant.broken_away(finger));
    return told;
  }
  [[nodiscard]] bool is_open(std::size_t finger) {
    const auto joint = plant.joint(finger);
    return std::abs(joint.motor) < 700.0 && std::abs(joint.joint) < 300.0;  // counts: half a degree
  }
  /// The next program: it may not look for a zero, so one that it has is known.
  void start_anew() {
    hal::BarrettHandConfig config;
    config.initialise = "never";
    auto next = std::make_unique<hal::BarrettHand>(*client, config, clock);
    driver = next.get();
    hand = std::move(next);
    const auto configured = hand->configure();
    INFO((configured ? std::string() : configured.error().text()));
    REQUIRE(configured);
    pass(200ms);
  }
};

}  // namespace

TEST_CASE("one finger alone brings its clutch back when it opens, and its zero stays known",
          "[hand][service]") {
  BrokenAway h;
  h.hand->deactivate();
  hal::FingerMotion open;
  open.finger = Puck::F2;
  open.value = 0.0;
  const auto refused = hal::move_finger(*h.client, h.clock, {}, open);
  REQUIRE_FALSE(refused);  // it may hold something
  CHECK(h.plant.broken_away(1));
  open.although_closed = true;
  const auto end = hal::move_finger(*h.client, h.clock, {}, open);
  INFO((end ? end->how : end.error().text()));
  REQUIRE(end);
  CHECK(end->as_asked);
  CHECK(end->rests);
  h.start_anew();
  CHECK_FALSE(h.is_broken_away(1));
  CHECK(h.is_open(1));
  // the others still hold
  CHECK(h.is_broken_away(0));
  CHECK(h.is_broken_away(2));
}

TEST_CASE("an emergency opening brings the clutches back, and the next program knows the zeros",
          "[hand][faults]") {
  BrokenAway h;
  const auto fingers = hal::emergency_open(*h.client, h.clock, {});
  REQUIRE(fingers);
  h.start_anew();
  for (std::size_t f = 0; f < 3; ++f) {
    CHECK((*fingers)[f].rests);
    CHECK_FALSE(h.is_broken_away(f));
    CHECK(h.is_open(f));
  }
  CHECK_FALSE(h.driver->report().loaded);
}

TEST_CASE("a program that starts while clutches have given way believes the zeros, holds and opens",
          "[hand][zero]") {
  BrokenAway h;
  h.hand->deactivate();
  h.start_anew();
  for (std::size_t f = 0; f < 3; ++f) CHECK(h.is_broken_away(f));
  CHECK(h.driver->report().loaded);
  REQUIRE(h.hand->activate());
  REQUIRE(h.hand->release());
  h.pass(2500ms);
  INFO(h.driver->report().why.str());
  CHECK(h.driver->report().why.empty());
  for (std::size_t f = 0; f < 3; ++f) {
    CHECK_FALSE(h.is_broken_away(f));
    CHECK(h.is_open(f));
  }
}
