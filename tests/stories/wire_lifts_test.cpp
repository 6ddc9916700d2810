// Whole lifts over the arm's real driver: FRI datagrams to an emulated controller, in lock step. And what the
// job does when that wire or that controller fails in each phase (safety-and-faults, rows 36 to 48).

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <string>
#include <string_view>

#include "control/config/arm_mode.hpp"
#include "hal/guards/t1_profile.hpp"
#include "tests/support/fault_table.hpp"
#include "tests/support/forked_lifts.hpp"
#include "tests/support/thorough.hpp"

namespace {

using namespace colift;
using control::Task;
using Result = control::RunRecord::Result;

/// A phase of the job, and a moment in it: the arm is under way, the fingers are closing or opening.
struct Phase {
  Task task;
  double at_s;
};
constexpr std::array<Phase, 11> kPhases{{{Task::AwaitPartner, 0.3},
                                         {Task::Approach, 1.0},
                                         {Task::Close, 0.3},
                                         {Task::Lift, 1.0},
                                         {Task::Hold, 0.3},
                                         {Task::Lower, 1.0},
                                         {Task::Release, 0.2},
                                         {Task::Retreat, 1.5},
                                         {Task::Verify, 0.1},
                                         {Task::AwaitReady, 0.2},
                                         {Task::BackOff, 0.5}}};
constexpr std::size_t kPhasesOfEvery = 8;  // the others only where it is to be thorough

tests::ForkedFault fault_at(const std::string& what, const Phase& phase) {
  auto parsed = sim_hal::parse_krc_fault(fmt::format("{}:{}", phase.at_s, what));
  if (!parsed) FAIL(parsed.error().text());
  return {*parsed, phase.task};
}

/// The default scenario without the camera's noise and with a short hold: what the wire does is the same.
std::vector<tests::ForkedEnd> lift_with(const std::vector<tests::ForkedFault>& faults,
                                        const tests::OverWire& wire = {}) {
  sim_hal::Scenario scenario = sim_hal::built_in_scenario();
  scenario.camera.noise = "none";
  scenario.task.hold_s = 1.0;
  return tests::lift_forked(scenario, control::run_defaults(), wire, faults);
}

bool hand_at_object(Task task) {
  return task == Task::Close || task == Task::Verify || task == Task::AwaitReady || task == Task::Lift ||
         task == Task::Hold || task == Task::Lower;
}

}  // namespace

TEST_CASE("a table is lifted over the arm's wire, and the controller has nothing to complain of", "[wire]") {
  const auto lift = tests::simulate(sim_hal::built_in_scenario(), control::Method::Fast, 1,
                                    control::run_defaults(), tests::OverWire{});
  INFO(lift.record.reason);
  REQUIRE(lift.record.outcome == Result::Lifted);
  CHECK(lift.tilt_deg < 1.0);
  CHECK(lift.record.faults.empty());
  CHECK(lift.wire->broken_rules_in_all == 0);
  CHECK(lift.wire->command_cycles > 5000);
  CHECK_FALSE(lift.hit_something);
}

namespace {

/// What has to come of a fault, a letter for each phase:
///   +  nothing worth a stop: the lift goes on to its end
///   .  at rest where it is; a hand that holds goes on holding; a person looks first
///   v  a limit of the load: set down, released, home, without the goal
///   space  the fault cannot show there
struct Row {
  const char* rows;   ///< Of the fault table.
  const char* fault;  ///< As `emulate krc --fault` takes it, without its time.
  std::string_view ends;
  const char* says;  ///< What the reason has to name, where it stops.
};

// phases: await-partner (observe is the same to the arm), approach, close, lift, hold, lower, release,
// retreat; verify, await-ready; back-off, after which a partner is waited for as without the fault
const Row kRows[] = {
    {"36, three lost", "loss=3", "+++++++++++", ""},
    {"36, twenty lost", "loss=20", "...........", "command mode"},
    {"37, doubled", "duplicate:1", "+++++++++++", ""},
    {"37, reordered", "reorder:1", "...........", "takes no commands"},
    {"38, corrupted", "corrupt:0.1", "...........", "arm"},
    {"39, a burst", "burst=25", "...........", "arm"},
    {"40, bad", "quality=1:1", "+++++++++++", ""},
    {"40, unacceptable", "quality=0:0.5", "...........", "command mode"},
    {"41, monitor mode", "monitor", "...........", "command mode"},
    {"42, emergency stop", "emergency-stop", "...........", "drives are off"},
    {"42, drive error", "drive-error@2", "...........", "drive error of A2"},
    {"43, drive warning", "drive-warning@2:1", "+++++++++++", ""},
    {"43, hot", "temperature=90:1", "...........", "90 deg C"},
    {"44, off and on", "unplug:1", "...........", "arm"},
    {"46, jump", "jump=0.2@3:0.1", "...........", "jump"},
    // an arm that holds still may well be still, and it has hardly set out when a second of Release is over
    {"46, stuck", "freeze:1", "+.+.+.+.+..", ""},
    {"46, not a number", "nan@3:0.05", "...........", "arm"},
    // while the object is borne a wrong torque is a wrong load, within its limit; a hand at work feels
    // nothing; beside the object it passes for a contact that ends
    {"47, torque offset", "torque-offset=20@2:1", "+.++++.+++.", ""},
    // in the air 60 N more look like a partner who let go: the arm pauses, then lifts on with him. Before the
    // hand opens they are a load that has to go first
    {"48, contact", "contact=60:1", "...++++....", ""},
};

void check(const Row& row, Task in, char expected, const tests::ForkedEnd& lift) {
  INFO(row.rows << " in " << control::word(in) << ", expected " << expected << " " << lift.crash << "\n"
                << lift.reason << "\n"
                << lift.told);
  REQUIRE(lift.crash.empty());
  REQUIRE(lift.ran);
  if (expected == '+') {
    CHECK(lift.outcome == Result::Lifted);
  } else {
    CHECK(lift.outcome == Result::Aborted);
    CHECK(lift.end == (expected == '.' ? Task::Stopped : Task::Aborted));
    CHECK_THAT(lift.reason, Catch::Contains(row.says));
  }
  // the hand never opens on a load but when the object stands again
  if (hand_at_object(in) && in != Task::Close) CHECK(lift.hand_keeps_grip == (expected == '.'));
  CHECK_FALSE(lift.hit_something);
  CHECK(lift.divergences == 0);
  // whatever happened, the client itself kept the controller's rules: silence on a datagram that is no number
  // is its duty, and the controller counts it
  CHECK(lift.broken_rules <= (std::string_view(row.fault).starts_with("nan") ? 1u : 0u));
}

/// All rows in the phases from `first` to before `end`.
void check_rows(std::size_t first, std::size_t end) {
  std::vector<tests::ForkedFault> faults;
  std::vector<std::pair<const Row*, std::size_t>> of;
  for (std::size_t p = first; p < end; ++p)
    for (const Row& row : kRows) {
      if (row.ends[p] == ' ' || !tests::chosen(static_cast<std::size_t>(&row - kRows), p)) continue;
      faults.push_back(fault_at(row.fault, kPhases[p]));
      of.emplace_back(&row, p);
    }
  const auto lifts = lift_with(faults);
  for (std::size_t i = 0; i < lifts.size(); ++i)
    check(*of[i].first, kPhases[of[i].second].task, of[i].first->ends[of[i].second], lifts[i]);
}

}  // namespace

TEST_CASE("the faults of wire and controller that are injected here", "[.fault-table]") {
  for (std::size_t p = 0; p < kPhases.size(); ++p)
    for (const Row& row : kRows)
      if (row.ends[p] != ' ')
        tests::print_fault(row.rows, kPhases[p].task,
                           p < kPhasesOfEvery && tests::chosen(static_cast<std::size_t>(&row - kRows), p));
  for (const Task in : {Task::Plan, Task::Approach, Task::Lift, Task::Hold, Task::Lower, Task::Retreat})
    tests::print_fault("45, joint near its limit", in, true);
}

TEST_CASE("faults of wire and controller until the hand is closed end as they have to", "[wire][faults]") {
  check_rows(0, 3);
}

TEST_CASE("faults of wire and controller while the object is borne, and after, end as they have to",
          "[wire][faults]") {
  check_rows(3, kPhasesOfEvery);
}

TEST_CASE(
    "faults of wire and controller while the grip is checked and the partner awaited end as they have to",
    "[wire][faults]") {
  if (tests::thorough()) check_rows(kPhasesOfEvery, kPhases.size() - 1);
}

TEST_CASE("faults of wire and controller on the way back from a grasp that is off end as they have to",
          "[wire][faults]") {
  if (!tests::thorough()) return;
  auto scenario =
      sim_hal::load_scenario(std::string(COLIFT_SOURCE_DIR) + "/config/scenario/partner_lets_go.yaml");
  REQUIRE(scenario);
  scenario->camera.noise = "none";
  control::Config config = control::run_defaults();
  config.task.partner_timeout_s = 2.5;
  const Phase& back_off = kPhases.back();
  std::vector<tests::ForkedFault> faults;
  for (const Row& row : kRows) faults.push_back(fault_at(row.fault, back_off));
  const auto lifts = tests::lift_forked(*scenario, config, tests::OverWire{}, faults);
  for (std::size_t i = 0; i < lifts.size(); ++i) {
    const auto& lift = lifts[i];
    INFO(kRows[i].rows << " in back-off, expected " << kRows[i].ends.back() << " " << lift.crash << "\n"
                       << lift.reason << "\n"
                       << lift.told);
    REQUIRE(lift.crash.empty());
    REQUIRE(lift.ran);
    CHECK(lift.outcome == Result::Aborted);
    if (kRows[i].ends.back() == '+') {
      CHECK(lift.end == Task::Refused);
      CHECK_THAT(lift.told, Catch::Contains("back where it started"));
    } else {
      CHECK(lift.end == Task::Stopped);
      CHECK_THAT(lift.reason, Catch::Contains(kRows[i].says));
    }
    CHECK_FALSE(lift.hand_keeps_grip);
    CHECK_FALSE(lift.hit_something);
    CHECK(lift.divergences == 0);
    CHECK(lift.broken_rules <= (std::string_view(kRows[i].fault).starts_with("nan") ? 1u : 0u));
  }
}

namespace {

/// A controller that stays in command mode over a gap. The one above leaves it after three missing answers.
tests::OverWire patient() {
  tests::OverWire wire;
  wire.extrapolated = 200;
  wire.min_rate = 0.05;
  return wire;
}

}  // namespace

TEST_CASE("while the controller is patient, a gap that heals makes the arm rest and go on in each phase",
          "[wire][faults]") {
  std::vector<tests::ForkedFault> faults;
  const char* const gaps[] = {"loss.out=12", "loss.out=30", "burst.out=25:0.05"};
  for (std::size_t p = 0; p < kPhasesOfEvery; ++p)
    for (std::size_t g = 0; g < std::size(gaps); ++g)
      if (tests::chosen(g, p)) faults.push_back(fault_at(gaps[g], kPhases[p]));
  const auto lifts = lift_with(faults, patient());
  for (std::size_t i = 0; i < lifts.size(); ++i) {
    const auto& lift = lifts[i];
    INFO(std::get<sim_hal::KrcFault>(faults[i].fault).text << " in " << control::word(faults[i].in) << " "
                                                           << lift.crash << "\n"
                                                           << lift.reason << "\n"
                                                           << lift.told);
    REQUIRE(lift.ran);
    CHECK(lift.outcome == Result::Lifted);
    CHECK_THAT(lift.told, Catch::Contains("takes commands again after"));
    CHECK_THAT(lift.told, Catch::Contains("continues from the current position"));
    CHECK_FALSE(lift.hit_something);
    CHECK(lift.divergences == 0);
    CHECK(lift.broken_rules == 0);
  }
}

TEST_CASE("while the controller is patient, a gap that does not heal in time ends in a hold",
          "[wire][faults]") {
  std::vector<tests::ForkedFault> faults;
  for (std::size_t p = 0; p < kPhasesOfEvery; ++p)
    if (tests::chosen(1, p)) faults.push_back(fault_at("loss:0.3", kPhases[p]));
  const auto lifts = lift_with(faults, patient());
  for (std::size_t i = 0; i < lifts.size(); ++i) {
    const auto& lift = lifts[i];
    INFO(control::word(faults[i].in) << " " << lift.crash << "\n" << lift.told);
    REQUIRE(lift.ran);
    CHECK(lift.end == Task::Stopped);
    if (hand_at_object(faults[i].in) && faults[i].in != Task::Close) CHECK(lift.hand_keeps_grip);
    CHECK_FALSE(lift.hit_something);
  }
}

TEST_CASE("while the controller warns, the arm really goes slower (rows 40 and 43)", "[wire][faults]") {
  const Phase approach{Task::Approach, 0.0}, lift{Task::Lift, 0.0}, retreat{Task::Retreat, 0.0};
  std::vector<tests::ForkedFault> faults;
  for (const Phase& phase : {approach, lift, retreat})
    for (const char* what : {"loss=1", "quality=1:60", "drive-warning@2:60", "temperature=75:60"})
      faults.push_back(fault_at(what, phase));
  const auto lifts = lift_with(faults);
  for (std::size_t i = 0; i < lifts.size(); ++i) {
    INFO(std::get<sim_hal::KrcFault>(faults[i].fault).text << " in " << control::word(faults[i].in) << "\n"
                                                           << lifts[i].told);
    REQUIRE(lifts[i].ran);
    CHECK(lifts[i].outcome == Result::Lifted);
    CHECK(lifts[i].broken_rules == 0);
    if (i % 4 == 0) continue;  // the first of four is as fast as planned
    CHECK(lifts[i].in_state_s > 2.2 * lifts[i - i % 4].in_state_s);
    CHECK(lifts[i].in_state_s < 4.0 * lifts[i - i % 4].in_state_s);
    CHECK_THAT(lifts[i].told, Catch::Contains("continues at reduced speed"));
  }
}

TEST_CASE(
    "a joint near its limit is planned around, and where no plan foresaw it the arm stops before (row 45)",
    "[wire][faults]") {
  auto scenario = sim_hal::load_scenario(std::string(COLIFT_SOURCE_DIR) + "/config/scenario/box.yaml");
  REQUIRE(scenario);
  scenario->camera.noise = "none";
  control::Config config = control::run_defaults();
  const hal::RobotModel robot = hal::built_in_robot();

  // while it lifts this box from above, A4 comes as near as 17.5 deg: a plan that knows nothing of it
  config.task.limit_margin_deg = 19.0;
  const auto stopped = tests::simulate(*scenario, control::Method::Fast, 1, config, tests::OverWire{});
  INFO(stopped.record.reason);
  CHECK(stopped.record.outcome == Result::Aborted);
  CHECK(stopped.record.states.back().state == Task::Stopped);
  CHECK_THAT(stopped.record.reason, Catch::Contains("A4 is 19."));
  CHECK(stopped.record.hand_keeps_grip);
  CHECK(stopped.at_end.robot_touches_object);
  CHECK(stopped.at_end.height_m > 0.005);
  CHECK(tests::to_limit_deg(robot, stopped.at_end.q_rad) >
        19.0 - 0.3);  // the springs of the impedance give a little
  CHECK(stopped.record.faults.empty());
  CHECK(stopped.wire->broken_rules_in_all == 0);

  // a plan that knows it takes another grasp or posture, and keeps away from it on every way
  config.motion.limit_margin_deg = 19.0;
  const auto around = tests::simulate(*scenario, control::Method::Fast, 1, config, tests::OverWire{});
  INFO(around.record.reason);
  CHECK(around.record.outcome == Result::Lifted);
  CHECK(around.to_limit_deg > 19.0 - 0.3);
  CHECK(around.tilt_deg < 1.0);
}

TEST_CASE("in T1 a whole lift keeps below the speed that the controller stops at", "[wire]") {
  control::Config config = control::run_defaults();
  config.arm_mode = "t1";
  tests::OverWire wire;
  wire.joint_rad_s = hal::kT1Velocity_rad_s;
  sim_hal::Scenario scenario = sim_hal::built_in_scenario();
  scenario.camera.noise = "none";
  const auto lift = tests::simulate(scenario, control::Method::Fast, 1, control::for_arm_mode(config), wire);
  INFO(lift.record.reason);
  CHECK(lift.record.outcome == Result::Lifted);
  CHECK(lift.wire->broken_rules_in_all == 0);
  // and without the profile it would not
  const auto fast = tests::simulate(scenario, control::Method::Fast, 1, control::run_defaults(), wire);
  CHECK(fast.record.outcome == Result::Aborted);
  CHECK(fast.wire->broken_rules_in_all > 0);
}
