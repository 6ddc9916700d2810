// Every cell of the tactile arrays through hal::Hand, and what the patterns tell, on emulated pucks.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <optional>

#include "hal/drivers/barrett_can/tactile/pattern_slip.hpp"
#include "tests/contract/barrett_rig.hpp"

using namespace colift;
using namespace std::chrono_literals;

namespace {

hal::HandState gripped(BarrettRig& rig, double palm_n = 0.0) {
  REQUIRE(rig.hand->configure());
  REQUIRE(rig.hand->activate());
  // start-up has tared the arrays: nothing may press on them until then
  sim_hal::HandObject object = sim_hal::HandObject::of_width(BarrettRig::kObject_m);
  object.palm_n = palm_n;
  rig.plant.put(object);
  REQUIRE(rig.hand->close(0.6));
  rig.pass(2500ms);
  const auto state = rig.hand->state();
  INFO((state ? std::string() : state.error().text()));
  REQUIRE(state);
  CHECK(state->held);
  return *state;
}

int touched(const hal::TactileArray& array) {
  return static_cast<int>(std::count_if(array.pressure_n_cm2.begin(), array.pressure_n_cm2.end(),
                                        [](float p) { return p > 0.1F; }));
}

hal::TactileArray spot(hal::Timestamp at, std::size_t row, float pressure = 2.0F) {
  hal::TactileArray a;
  a.measured_at = at;
  a.pressure_n_cm2.fill(0.0F);
  for (std::size_t c = 0; c < 3; ++c) a.pressure_n_cm2[3 * row + c] = pressure;
  return a;
}

}  // namespace

TEST_CASE("24 cells of each finger and of the palm come through the hand's state", "[hand][tactile]") {
  BarrettRig rig(true);
  const auto state = gripped(rig, 5.0);
  for (std::size_t f = 0; f < hal::kFingers; ++f) {
    INFO("F" << f + 1);
    CHECK(touched(state.tactile[f]) == 9);  // three rows of the pad's middle
    for (std::size_t cell = 0; cell < hal::kArrayCells; ++cell) {
      const bool middle = cell >= 6 && cell < 15;
      CHECK((state.tactile[f].pressure_n_cm2[cell] > 0.1F) == middle);
    }
    CHECK(state.tip_force_n[f] > 1.0);
    CHECK(rig.clock.now() - state.tactile[f].measured_at < 60ms);
  }
  CHECK(touched(state.tactile[hal::kPalmArray]) == 24);
  CHECK(state.palm_force_n == Approx(5.0).margin(0.3));
}

TEST_CASE("a hand without tactile sensors, or with them off, has NaN in every cell", "[hand][tactile]") {
  const bool off = GENERATE(true, false);
  hal::BarrettHandConfig config;
  if (off) config.tactile = "off";
  sim_hal::HandEmulatorConfig pucks;
  if (!off) pucks.puck.finger_role = 0x0e05, pucks.puck.spread_role = 0x0605;  // strain gauges alone
  BarrettRig rig(true, config, pucks);
  const auto state = gripped(rig);
  for (const auto& array : state.tactile) {
    CHECK(array.measured_at == hal::Timestamp{0});
    for (const float cell : array.pressure_n_cm2) CHECK(std::isnan(cell));
  }
  CHECK(std::isnan(state.palm_force_n));
}

TEST_CASE("a pattern that moves over the pads is a slip within 50 ms, with the forces unchanged",
          "[hand][tactile][slip]") {
  BarrettRig rig(true);
  (void)gripped(rig);
  rig.pass(500ms);
  REQUIRE_FALSE(rig.driver->report().slipped);
  sim_hal::HandObject moved = sim_hal::HandObject::of_width(BarrettRig::kObject_m);
  moved.pad_rows = 1;  // 6 mm
  rig.plant.put(moved);
  const hal::Timestamp at = rig.clock.now();
  std::optional<hal::Duration> after;
  rig.pass(200ms, [&] {
    if (!after && rig.driver->report().slipped) after = rig.clock.now() - at;
  });
  REQUIRE(after);
  CHECK(*after <= 50ms);
  CHECK(rig.driver->report().why.str().find("pattern") != std::string::npos);
  CHECK(rig.hand->state()->held);
}

TEST_CASE("one pad that jumps, a slow shift, a pad that lifts off: no slip", "[tactile][slip]") {
  using Pads = std::array<hal::TactileArray, hal::kFingers>;
  hal::barrett::PatternSlip slip;
  const std::array<bool, hal::kFingers> holding{true, true, true};
  hal::Timestamp t{1s};
  const auto add = [&](const Pads& pads) { slip.add(pads, holding); };
  for (int i = 0; i < 40; ++i, t += 25ms) add({spot(t, 3), spot(t, 3), spot(t, 3)});
  for (int i = 0; i < 40; ++i, t += 25ms) add({spot(t, 6), spot(t, 3), spot(t, 3)});
  CHECK_FALSE(slip.slipped());
  slip.start();
  // half of the force wanders to the next row in two seconds
  for (int i = 0; i < 80; ++i, t += 25ms) {
    Pads pads{spot(t, 3), spot(t, 3), spot(t, 3)};
    for (auto& pad : pads)
      for (std::size_t c = 0; c < 3; ++c) pad.pressure_n_cm2[12 + c] = 2.0F * static_cast<float>(i) / 80.0F;
    add(pads);
  }
  CHECK_FALSE(slip.slipped());
  slip.start();
  add({spot(t, 3), spot(t, 3), spot(t, 3)});
  t += 25ms;
  add({spot(t, 3, 0.0F), spot(t, 3, 0.0F), spot(t, 3)});
  t += 25ms;
  add({spot(t, 6), spot(t, 6), spot(t, 3)});
  CHECK_FALSE(slip.slipped());
  t += 25ms;
  add({spot(t, 3), spot(t, 3), spot(t, 3)});
  CHECK(slip.slipped());  // and both at once
}
