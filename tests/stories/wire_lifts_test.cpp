// Whole lifts over the arm's real driver: FRI datagrams to an emulated controller, in lock step. And what the
// job does when that wire or that controller fails in each phase (safety-and-faults, rows 36 to 48).

#include <algorithm>
#include <catch2/catch.hpp>
#include <string>

#include "tests/support/lift_figures.hpp"

namespace {

using namespace colift;
using control::Task;
using Result = control::RunRecord::Result;

tests::SimulatedLift lift_with(const std::string& fault = "", Task in = Task::Approach,
                               std::uint64_t seed = 1) {
  tests::OverWire wire;
  if (!fault.empty()) {
    auto parsed = sim_hal::parse_krc_fault(fault);
    if (!parsed) FAIL(parsed.error().text());
    wire.faults.push_back({*parsed, in});
  }
  return tests::simulate(sim_hal::built_in_scenario(), control::Method::Fast, seed, control::run_defaults(),
                         wire);
}

std::string told(const tests::SimulatedLift& lift) {
  std::string all = lift.record.because + "\n";
  for (const auto& s : lift.record.states)
    all += std::string(control::word(s.state)) + ": " + s.because + "\n";
  for (const auto& f : lift.record.faults) all += f.device + ": " + f.what + "\n";
  for (const auto& b : lift.wire->broken_rules) all += "broken: " + b.because + "\n";
  for (const auto& m : lift.wire->mode_changes) all += "mode: " + m.because + "\n";
  return all;
}

}  // namespace

TEST_CASE("a table is lifted over the arm's wire, and the controller has nothing to complain of", "[wire]") {
  const auto lift = lift_with();
  INFO(told(lift));
  REQUIRE(lift.record.outcome == Result::Lifted);
  CHECK(lift.tilt_deg < 1.0);
  CHECK(lift.record.faults.empty());
  CHECK(lift.wire->broken_rules_in_all == 0);
  CHECK(lift.wire->command_cycles > 5000);
  CHECK_FALSE(lift.hit_something);
}

namespace {

/// A fault half a second into a state, and what has to come of it in each of three states.
enum class End {
  Lifted,   ///< Nothing worth a stop: the lift goes on.
  Stopped,  ///< At rest where it is; a hand that holds goes on holding; a person looks first.
  SetDown,  ///< A limit of the load: set down, released, home.
};
struct Row {
  const char* rows;   ///< Of reference/safety-and-faults.
  const char* fault;  ///< As `emulate krc --fault` takes it.
  End approach, lift, hold;
  const char* says;  ///< What the reason has to name.
};

constexpr End kOn = End::Lifted, kStop = End::Stopped;
const Row kRows[] = {
    {"36, three lost", "0.5:loss=3", kOn, kOn, kOn, "held"},
    {"36, twenty lost", "0.5:loss=20", kStop, kStop, kStop, "command mode"},
    {"37, doubled", "0.5:duplicate:1", kOn, kOn, kOn, "held"},
    {"37, reordered", "0.5:reorder:1", kStop, kStop, kStop, "takes no commands"},
    {"38, corrupted", "0.5:corrupt:0.1", kStop, kStop, kStop, "arm"},
    {"39, a burst", "0.5:burst=25", kStop, kStop, kStop, "arm"},
    {"40, bad", "0.5:quality=1:1", kOn, kOn, kOn, "held"},
    {"40, unacceptable", "0.5:quality=0:0.5", kStop, kStop, kStop, "command mode"},
    {"41, monitor mode", "0.5:monitor", kStop, kStop, kStop, "command mode"},
    {"42, emergency stop", "0.5:emergency-stop", kStop, kStop, kStop, "drives are off"},
    {"42, drive error", "0.5:drive-error@2", kStop, kStop, kStop, "drive error of A2"},
    {"43, drive warning", "0.5:drive-warning@2:1", kOn, kOn, kOn, "held"},
    {"43, hot", "0.5:temperature=90:1", kStop, kStop, kStop, "90 deg C"},
    {"44, off and on", "0.5:unplug:1", kStop, kStop, kStop, "arm"},
    {"46, jump", "0.5:jump=0.2@3:0.1", kStop, kStop, kStop, "jump"},
    {"46, stuck", "0.5:freeze:1", kStop, kStop, kOn, ""},  // an arm that holds still may well be still
    {"46, not a number", "0.5:nan@3:0.05", kStop, kStop, kStop, "arm"},
    {"47, torque offset", "0.5:torque-offset=20@2:1", kStop, kOn, kStop, ""},
    {"48, contact", "0.5:contact=60:1", kStop, End::SetDown, kStop, ""},
};

void check(const Row& row, Task in, End expected) {
  const auto lift = lift_with(row.fault, in);
  INFO(row.rows << " in " << control::word(in) << "\n" << told(lift));
  const Task end = lift.record.states.back().state;
  if (expected == End::Lifted) {
    CHECK(lift.record.outcome == Result::Lifted);
  } else {
    CHECK(lift.record.outcome == Result::Aborted);
    CHECK(end == (expected == End::Stopped ? Task::Stopped : Task::Aborted));
  }
  CHECK_THAT(lift.record.because, Catch::Contains(row.says));
  // the hand never opens on a load but when the object stands again
  CHECK(lift.record.hand_keeps_grip == (expected == End::Stopped && in != Task::Approach));
  CHECK_FALSE(lift.hit_something);
  CHECK(lift.at_end.troubles == 0);
  // whatever happened, the client itself kept the controller's rules: silence on a datagram that is no number
  // is its duty, and the controller counts it
  CHECK(lift.wire->broken_rules_in_all <= (row.fault == std::string("0.5:nan@3:0.05") ? 1u : 0u));
}

}  // namespace

TEST_CASE("faults of the wire and the controller on the approach end as they have to", "[wire][faults]") {
  for (const Row& row : kRows) check(row, Task::Approach, row.approach);
}

TEST_CASE("faults of the wire and the controller while lifting end as they have to", "[wire][faults]") {
  for (const Row& row : kRows) check(row, Task::Lift, row.lift);
}

TEST_CASE("faults of the wire and the controller while holding end as they have to", "[wire][faults]") {
  for (const Row& row : kRows) check(row, Task::Hold, row.hold);
}
