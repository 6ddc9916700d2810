// Whole lifts over the hand's real driver: CAN frames to four emulated pucks, in lock step. And what the job
// does when that bus or those pucks fail in each phase (safety-and-faults, rows 21 and 25 to 34).

#include <algorithm>
#include <catch2/catch.hpp>
#include <string>

#include "tests/support/fault_table.hpp"
#include "tests/support/forked_lifts.hpp"
#include "tests/support/lift_figures.hpp"
#include "tests/support/thorough.hpp"

namespace {

using namespace colift;
using control::Task;
using Result = control::RunRecord::Result;

struct InPhase {
  const char* fault;  ///< As `emulate hand --fault` takes it; its time counts from the phase's begin.
  Task in;
  bool each_time = false;  ///< At every entry into the phase.
};

sim_hal::Scenario quick_table() {
  sim_hal::Scenario s = sim_hal::built_in_scenario();
  s.task.height = 0.03;
  s.task.hold_s = 1.0;
  return s;
}

tests::SimulatedLift lift_with(const std::vector<InPhase>& faults,
                               const sim_hal::Scenario& scenario = quick_table(),
                               control::Config config = control::run_defaults(),
                               const hal::Vec3& camera_off_m = hal::Vec3::Zero()) {
  tests::OverWire wire;
  wire.arm = false;
  wire.hand = true;
  wire.camera_off_m = camera_off_m;
  for (const InPhase& f : faults) {
    auto parsed = sim_hal::parse_hand_fault(f.fault);
    if (!parsed) FAIL(parsed.error().text());
    wire.hand_faults.push_back({*parsed, f.in, f.each_time});
  }
  config.task.lift_s = 1.0;
  return tests::simulate(scenario, control::Method::Fast, 1, config, wire);
}

std::uint64_t rules_broken(const tests::SimulatedLift& lift) {
  std::uint64_t all = 0;
  for (const std::uint64_t times : lift.pucks->broken) all += times;
  return all;
}

std::string told(const tests::SimulatedLift& lift) {
  std::string all = lift.record.reason + "\n";
  for (const auto& s : lift.record.states)
    all += std::string(control::word(s.state)) + ": " + s.reason + "\n";
  for (const auto& f : lift.record.faults) all += f.device + ": " + f.what + "\n";
  for (std::size_t r = 0; r < sim_hal::kHandRules; ++r)
    if (lift.pucks->broken[r] > 0)
      all += "broken: " + std::string(sim_hal::kHandRuleNames[r]) + ": " + lift.pucks->first[r] + "\n";
  return all;
}

bool went_through(const tests::SimulatedLift& lift, Task task) {
  return std::any_of(lift.record.states.begin(), lift.record.states.end(),
                     [&](const auto& s) { return s.state == task; });
}

std::ptrdiff_t times(const tests::SimulatedLift& lift, Task task) {
  return std::count_if(lift.record.states.begin(), lift.record.states.end(),
                       [&](const auto& s) { return s.state == task; });
}

bool said(const tests::SimulatedLift& lift, const std::string& words) {
  return told(lift).find(words) != std::string::npos;
}

constexpr double kPlay_rad = 0.03;  // a finger gives as its gear winds

}  // namespace

TEST_CASE(
    "a table is lifted over the hand's bus with the default torque, and the pucks have nothing to complain "
    "of",
    "[bus]") {
  for (const double torque_nm : {1.0, 0.5}) {
    control::Config config = control::run_defaults();
    config.task.close_torque_nm = torque_nm;
    const auto lift = lift_with({}, quick_table(), config);
    INFO(torque_nm << " N m\n" << told(lift));
    REQUIRE(lift.record.outcome == Result::Lifted);
    CHECK(lift.tilt_deg < 1.5);
    CHECK(lift.record.faults.empty());
    CHECK(rules_broken(lift) == 0);
    CHECK(lift.most_open_while_loaded_rad < kPlay_rad);
    CHECK_FALSE(lift.hit_something);
  }
}

TEST_CASE("what a bus may do is no reason to stop: lost, late, doubled, foreign frames, a passive bus",
          "[bus][faults]") {
  const auto lift = lift_with({{"0:loss=1:20", Task::Approach},
                               {"0:foreign:20", Task::Approach},
                               {"0.1:duplicate:1", Task::Close},
                               {"0.1:late=3:1", Task::Lift},
                               {"0.3:passive:0.3", Task::Lift},
                               {"0.2:noise:0.5", Task::Hold},
                               {"0.1:corrupt=5:0.5", Task::Lower},
                               {"0.1:late=3:0.5", Task::Release}});
  INFO(told(lift));
  CHECK(lift.record.outcome == Result::Lifted);
  CHECK(said(lift, "error passive"));
  CHECK(lift.most_open_while_loaded_rad < kPlay_rad);
}

namespace {

enum class End {
  Lifted,   ///< Nothing worth a stop: the lift goes on.
  Stopped,  ///< At rest where it is; a person looks first. A loaded hand goes on holding.
  Back,     ///< Never gripped: back home.
};
struct Row {
  const char* rows;  ///< Of the fault table.
  InPhase fault;
  End end;
  const char* says;
  bool seldom = false;  ///< Only where it is to be thorough.
};

const Row kOnApproach[] = {
    {"27 one puck silent", {"0.5:silent@F2:60", Task::Approach}, End::Stopped, "F2 (node 12) is silent"},
    {"28 too hot", {"0.5:hot=75:60", Task::Approach}, End::Back, "may not grip"},
    {"29 reset", {"0.3:reset@F1", Task::AwaitPartner}, End::Stopped, "F1 was reset"},
    {"29 reset", {"0.5:reset@F3", Task::Approach}, End::Stopped, "F3 was reset"},
    {"29 zero forgotten", {"0.5:jump=20000@F1", Task::Approach}, End::Stopped, "lost its zero"},
    {"30 bus-off", {"0.5:bus-off:60", Task::Approach}, End::Stopped, "bus"},
    {"32 interface down", {"0.5:down:60", Task::Approach}, End::Stopped, "hand"},
    {"33 full queue", {"0.5:full:60", Task::Approach}, End::Stopped, "hand"},
    {"34 all silent", {"0.5:silent:60", Task::Approach}, End::Stopped, "silent"},
};

const Row kClosingAndReleasing[] = {
    {"25 does not close, once", {"0:stuck:4", Task::Close}, End::Lifted, "tries again"},
    {"25 does not close", {"0:stuck:4", Task::Close, true}, End::Back, "does not move"},
    // nothing is held yet: the others open, and with one finger less nothing is tried again
    {"27 one puck silent", {"0.1:silent@F2:60", Task::Close}, End::Back, "F2 (node 12) is silent"},
    {"27 one puck silent", {"0.4:silent@F3:60", Task::Close}, End::Back, "F3 (node 13) is silent", true},
    {"27 the spread silent",
     {"0.1:silent@spread:60", Task::Close},
     End::Back,
     "spread (node 14) is silent",
     true},
    {"27 silent for a while", {"0.1:silent@F1:1", Task::Close}, End::Back, "F1 (node 11) is silent", true},
    {"34 all silent", {"0.1:silent:60", Task::Close}, End::Stopped, "all four pucks are silent", true},
    {"28 too hot", {"0.1:hot=75:60", Task::Close}, End::Back, "75 C"},
    {"29 reset", {"0.1:reset@F1", Task::Close}, End::Stopped, "F1 was reset"},
    {"30 bus-off", {"0.1:bus-off:60", Task::Close}, End::Stopped, "bus"},
    {"27 silent", {"0.1:silent@F3:60", Task::Release}, End::Stopped, "F3 (node 13) is silent"},
    {"29 reset", {"0.2:reset@F2", Task::Release}, End::Stopped, "F2 was reset"},
    {"29 reset", {"1:reset@F3", Task::Retreat}, End::Stopped, "F3 was reset"},
    {"25 does not open", {"0:stuck:60", Task::Release}, End::Stopped, "did not open"},
};

// As a lab finds a hand (not in the fault table): what is no fault of a device and stops the lift all the
// same.
const Row kLabClosing[] = {
    // its pucks fade from 44 C on, and the maker's limit is not reached: a tenth of the torque is no grip
    {"a heated hand", {"0:hot=57:60", Task::Close, true}, End::Back, "let it cool"},
    {"a second master while it closes", {"0.2:master=900@F2", Task::Close}, End::Stopped, "another program"},
};
const Row kLabLifting[] = {
    {"a pushed spread", {"0.4:turn=4000:2", Task::Lift}, End::Stopped, "the spread turned"},
    {"a second master", {"0.4:master=900@F1", Task::Lift}, End::Stopped, "another program"},
    {"a sagging supply", {"0.2:sag=20:60", Task::Lift}, End::Lifted, "supply gives 20 V"},
};

const Row kLifting[] = {
    {"27 one puck silent", {"0.4:silent@F2:60", Task::Lift}, End::Stopped, "F2 (node 12) is silent"},
    {"27 one puck silent", {"0.05:silent@F2:60", Task::Verify}, End::Stopped, "F2 (node 12) is silent"},
    {"27 one puck silent",
     {"0.1:silent@F1:60", Task::AwaitReady},
     End::Stopped,
     "F1 (node 11) is silent",
     true},
    {"28 too hot", {"0.4:hot=75:60", Task::Lift}, End::Stopped, "lower the object on request"},
    {"29 reset", {"0.4:reset@F3", Task::Lift}, End::Stopped, "F3 was reset"},
    {"29 all reset", {"0.4:brown-out", Task::Lift}, End::Stopped, "was reset"},
    {"29 in error", {"0.4:error=7@F1:60", Task::Lift}, End::Stopped, "code 7"},
    {"30 bus-off", {"0.4:bus-off:60", Task::Lift}, End::Stopped, "bus"},
    {"32 interface down", {"0.4:down:60", Task::Lift}, End::Stopped, "hand"},
    {"33 full queue", {"0.4:full:60", Task::Lift}, End::Stopped, "hand"},
    // asked as a group, all four answer with each other's names: only their leaps tell
    {"34 wrong puck", {"0.4:wrong:60", Task::Lift}, End::Stopped, "lost its zero"},
};

const Row kHoldingAndLowering[] = {
    {"27 silent", {"0.2:silent@F1:60", Task::Hold}, End::Stopped, "F1 (node 11) is silent"},
    {"28 too hot",
     {"0.2:hot=75:60", Task::Hold},
     End::Stopped,
     "the hand has 75 C (limit 65): lower the object"},
    // goes on slowly and sets it down; from 60 C on these pucks have no torque left to open
    {"28 warm", {"0.2:hot=62:60", Task::Hold}, End::Stopped, "62 C"},
    {"29 zero forgotten", {"0.2:jump=20000@F2", Task::Hold}, End::Stopped, "lost its zero"},
    {"30 bus-off, back soon", {"0.2:bus-off:0.3", Task::Hold}, End::Stopped, "bus"},
    {"34 none answers", {"0.2:loss=100:60", Task::Hold}, End::Stopped, "silent"},
    {"27 silent", {"0.2:silent@F2:60", Task::Lower}, End::Stopped, "F2 (node 12) is silent"},
    // set down; then its motors have no torque to open until they have cooled
    {"28 too hot", {"0.2:hot=75:60", Task::Lower}, End::Stopped, "did not open"},
    {"29 reset", {"0.2:reset@F1", Task::Lower}, End::Stopped, "F1 was reset"},
    {"30 bus-off", {"0.2:bus-off:60", Task::Lower}, End::Stopped, "bus"},
};

void check(const Row& row, const tests::ForkedEnd& lift) {
  INFO(row.rows << ": " << row.fault.fault << " in " << control::word(row.fault.in) << "\n"
                << lift.crash << "\n"
                << lift.reason << "\n"
                << lift.told);
  REQUIRE(lift.crash.empty());
  REQUIRE(lift.ran);
  const auto visited = [&](Task task) { return lift.visited.test(static_cast<std::size_t>(task)); };
  const bool in_air = row.fault.in == Task::Lift || row.fault.in == Task::Hold || row.fault.in == Task::Lower;
  switch (row.end) {
    case End::Lifted:
      CHECK(lift.outcome == Result::Lifted);
      break;
    case End::Stopped:
      CHECK(lift.outcome == Result::Aborted);
      CHECK(lift.end == Task::Stopped);
      if (in_air && !visited(Task::Release)) CHECK(lift.hand_keeps_grip);
      if (in_air) CHECK(lift.touches_object);
      break;
    case End::Back:
      CHECK(lift.outcome == Result::Aborted);
      CHECK_FALSE(visited(Task::Lift));
      CHECK((lift.end == Task::Aborted || lift.end == Task::Refused));
      break;
  }
  CHECK_THAT(lift.reason + lift.told, Catch::Contains(row.says));
  // whatever happened, no finger opened while the object was in the air
  if (in_air) CHECK(lift.most_open_while_loaded_rad < kPlay_rad);
  CHECK_FALSE(lift.hit_something);
  CHECK(lift.divergences == 0);
}

/// Each row branches off the same lift.
template <std::size_t N>
void check_rows(const Row (&rows)[N]) {
  std::vector<tests::ForkedFault> faults;
  std::vector<const Row*> of;
  for (const Row& row : rows) {
    if (row.seldom && !tests::thorough()) continue;
    if (tests::kSanitized && (&row - rows) % 3 != 0) continue;
    auto parsed = sim_hal::parse_hand_fault(row.fault.fault);
    if (!parsed) FAIL(parsed.error().text());
    faults.push_back({*parsed, row.fault.in, row.fault.each_time});
    of.push_back(&row);
  }
  tests::OverWire wire;
  wire.arm = false;
  wire.hand = true;
  control::Config config = control::run_defaults();
  config.task.lift_s = 1.0;
  const auto lifts = tests::lift_forked(quick_table(), config, wire, faults);
  for (std::size_t i = 0; i < lifts.size(); ++i) check(*of[i], lifts[i]);
}

}  // namespace

TEST_CASE("the faults of bus and pucks that are injected here", "[.fault-table]") {
  const auto print = [](const auto& rows) {
    for (const Row& row : rows) tests::print_fault(row.rows, row.fault.in, !row.seldom);
  };
  print(kOnApproach);
  print(kClosingAndReleasing);
  print(kLifting);
  print(kHoldingAndLowering);
  tests::print_fault("26 closed on nothing", Task::Close, true);
  tests::print_fault("31 error passive", Task::Lift, true);
}

TEST_CASE("faults of bus and pucks on the approach end as they have to", "[bus][faults]") {
  check_rows(kOnApproach);
}

TEST_CASE("faults of bus and pucks while closing and releasing end as they have to", "[bus][faults]") {
  check_rows(kClosingAndReleasing);
}

TEST_CASE("a heated hand and a second master end a grip before the lift", "[bus][faults]") {
  check_rows(kLabClosing);
}

TEST_CASE("a pushed spread and a second master stop a lift, and the grip is kept", "[bus][faults][loaded]") {
  check_rows(kLabLifting);
}

TEST_CASE("a table is lifted over a slow link", "[bus][faults]") {
  const auto lift = lift_with({{"0:late=30:120", Task::AwaitPartner}});
  INFO(told(lift));
  CHECK(lift.record.outcome == Result::Lifted);
  CHECK(lift.most_open_while_loaded_rad < kPlay_rad);
  CHECK(said(lift, "slow link"));
}

TEST_CASE("a hand that closes on nothing twice opens twice, and the arm goes home (row 26)",
          "[bus][faults]") {
  // what is seen stands further off than it is seen
  control::Config config = control::run_defaults();
  config.pose_check.on = false;
  config.self_filter.padding_m = config.map.robot_padding_m = 0.2;  // nor is the arm where it is seen
  const auto lift = lift_with({}, quick_table(), config, {-0.15, 0.0, 0.0});
  INFO(told(lift));
  CHECK(lift.record.outcome == Result::Aborted);
  CHECK(lift.record.states.back().state == Task::Aborted);
  CHECK(times(lift, Task::Close) == 2);
  CHECK(times(lift, Task::Release) == 2);
  CHECK_FALSE(went_through(lift, Task::Lift));
  CHECK(said(lift, "closed on nothing"));
  CHECK_FALSE(lift.record.hand_keeps_grip);
}

TEST_CASE("faults of bus and pucks while lifting end as they have to, and the grip is kept",
          "[bus][faults][loaded]") {
  check_rows(kLifting);
}

TEST_CASE("faults of bus and pucks while holding and lowering end as they have to, and the grip is kept",
          "[bus][faults][loaded]") {
  check_rows(kHoldingAndLowering);
}
