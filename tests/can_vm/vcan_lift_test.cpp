// A whole lift whose hand is reached over the kernel's own CAN: driver and emulated pucks each on a socket of
// vcan0, in lock step, so that a slow machine changes nothing.

#include <catch2/catch.hpp>

#include "tests/support/simulated_lift.hpp"

using namespace colift;

TEST_CASE("a table is lifted with the hand on vcan0", "[vcan]") {
  sim_hal::Scenario table = sim_hal::built_in_scenario();
  table.task.height = 0.03;
  table.task.hold_s = 1.0;
  tests::OverWire wire;
  wire.arm = false;
  wire.hand = true;
  wire.hand_bus = "socketcan:vcan0";
  const auto lift = tests::simulate(table, control::Method::Fast, 1, control::run_defaults(), wire);
  INFO(lift.record.reason);
  for (const auto& fault : lift.record.faults) UNSCOPED_INFO(fault.device << ": " << fault.what);
  REQUIRE(lift.record.outcome == control::RunRecord::Result::Lifted);
  CHECK(lift.record.faults.empty());
  CHECK(lift.tilt_deg < 1.5);
  CHECK(lift.frames_lost == 0);
  REQUIRE(lift.pucks);
  for (std::size_t r = 0; r < sim_hal::kHandRules; ++r) {
    INFO(sim_hal::kHandRuleNames[r] << ": " << lift.pucks->first[r]);
    CHECK(lift.pucks->broken[r] == 0);
  }
}
