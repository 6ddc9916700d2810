// Every shipped scenario ends as its own comment says.

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <string>
#include <string_view>

#include "control/session/pipeline.hpp"
#include "sim_hal/scenario/scenario.hpp"
#include "tests/support/fault_table.hpp"
#include "tests/support/lift_figures.hpp"
#include "tests/support/thorough.hpp"

namespace {

using namespace colift;
using control::Task;
using Result = control::RunRecord::Result;

const std::string kFolder = std::string(COLIFT_SOURCE_DIR) + "/config/scenario/";

tests::SimulatedLift run(const std::string& name, control::Method method = control::Method::Fast,
                         control::Config config = control::run_defaults()) {
  const auto scenario = sim_hal::load_scenario(kFolder + name + ".yaml");
  REQUIRE(scenario);
  return tests::simulate(*scenario, method, 1, std::move(config));
}

bool passed(const tests::SimulatedLift& lift, Task task) {
  return std::any_of(lift.record.states.begin(), lift.record.states.end(),
                     [task](const control::StateChange& s) { return s.state == task; });
}

std::string reason_for(const tests::SimulatedLift& lift, Task task) {
  for (const control::StateChange& s : lift.record.states)
    if (s.state == task) return s.reason;
  return "";
}

/// The plain lift of the table, made once for all stories about it.
const tests::SimulatedLift& lift_of_table() {
  static const tests::SimulatedLift lift = run("table");
  return lift;
}

void check_lifted(const std::string& name, double tilt_deg) {
  const tests::SimulatedLift lift = name == "table" ? lift_of_table() : run(name);
  INFO(tests::line(name, lift));
  REQUIRE(lift.record.outcome == Result::Lifted);
  CHECK(lift.tilt_deg < tilt_deg);
  CHECK(lift.slip_m < 0.01);
  CHECK_FALSE(lift.hit_something);
  CHECK_FALSE(lift.record.hand_keeps_grip);
  REQUIRE(lift.record.lift);
  // what the robot says of itself agrees with the truth
  CHECK(lift.record.lift->tilt_rad * 57.2958 == Approx(lift.tilt_deg).margin(1.5));
  CHECK(lift.record.lift->share_robot == Approx(lift.share_robot).margin(0.05));
  // the mass, of which nobody told it, is as true as the centre of gravity of the seen shape
  REQUIRE(lift.record.lift->load);
  const control::LoadEstimate& load = *lift.record.lift->load;
  CHECK(load.source == control::MassSource::Shape);
  CHECK(load.mass_kg == Approx(lift.at_end.mass_kg).epsilon(0.08));
  CHECK(load.mass_95.low < lift.at_end.mass_kg);
  CHECK(load.mass_95.high > lift.at_end.mass_kg);
  CHECK(load.share_95.low < lift.share_robot);
  CHECK(load.share_95.high > lift.share_robot);
}

}  // namespace

TEST_CASE("tables are lifted level, with clutter or a wall about them", "[scenario]") {
  for (const char* name : {"table", "table_pose_2", "cluttered_table", "wall_behind"})
    check_lifted(name, 1.0);
}

TEST_CASE("boxes, a pipe and a chair are lifted", "[scenario]") {
  for (const char* name : {"box", "box_partner_left", "box_partner_right", "pipe", "chair", "chair_pose_2"})
    check_lifted(name, 2.0);
}

TEST_CASE("somebody was in the path, and an operator confirms that the arm may continue", "[scenario]") {
  control::Config config = control::run_defaults();
  config.monitor.resume = false;
  const auto lift = run("confirmed_continuation", control::Method::Fast, config);
  INFO(tests::line("confirmed_continuation", lift));
  CHECK(lift.record.outcome == Result::Lifted);
  CHECK(lift.record.monitor.waited_s > 7.0);
  CHECK(lift.person_contacts == 0);
}

TEST_CASE("a partner who lifts first is followed", "[scenario]") {
  check_lifted("leader_table", 1.0);
}

TEST_CASE("on a fixed support the object tilts as far as geometry says, and that is no common lift",
          "[scenario]") {
  control::Config config = control::run_defaults();
  config.task.carry.partner_lag_m = 0.2;  // else the lift pauses: nobody lifts the other end
  const auto lift = run("support_table", control::Method::Fast, config);
  INFO(tests::line("support_table", lift));
  REQUIRE(passed(lift, Task::Hold));
  CHECK(lift.record.outcome == Result::Aborted);
  CHECK(lift.record.reason.find("not lifted: the robot's end was seen") != std::string::npos);
  CHECK(lift.tilt_deg > 3.0);
  CHECK(lift.tilt_deg < 4.5);
}

TEST_CASE("a wrong centre of gravity shows in the share, not in the tilt", "[scenario]") {
  const auto lift = run("wrong_cog");
  INFO(tests::line("wrong_cog", lift));
  REQUIRE(lift.record.outcome == Result::Lifted);
  CHECK(lift.tilt_deg < 1.0);
  CHECK(lift.share_robot < lift.record.lift->share_predicted - 0.1);
}

TEST_CASE("the faults of the partner that are injected here", "[.fault-table]") {
  tests::print_fault("13 lets go", control::Task::Approach, true);
  tests::print_fault("14 moves", control::Task::Approach, true);
}

TEST_CASE("a partner who moves during the approach is decided on anew", "[scenario]") {
  const auto lift = run("partner_moves");
  INFO(tests::line("partner_moves", lift));
  CHECK(lift.record.outcome == Result::Lifted);
  CHECK(passed(lift, Task::BackOff));
  CHECK(reason_for(lift, Task::BackOff).find("the partner") != std::string::npos);
}

TEST_CASE("a partner who lets go before the grasp sends the robot home", "[scenario]") {
  const auto lift = run("partner_lets_go");
  CHECK(lift.record.outcome == Result::Aborted);
  CHECK(passed(lift, Task::BackOff));
  CHECK_FALSE(passed(lift, Task::Close));
  CHECK_FALSE(lift.hit_something);
}

TEST_CASE("without a partner nothing moves", "[scenario]") {
  auto config = control::run_defaults();
  config.task.partner_timeout_s = 3.0;
  const auto lift = run("no_partner", control::Method::Fast, config);
  CHECK(lift.record.outcome == Result::Refused);
  CHECK(lift.record.reason.find("timeout: no partner") != std::string::npos);
  CHECK_FALSE(passed(lift, Task::Approach));
}

TEST_CASE("a partner whose own body hides his hand after he took hold has not let go", "[scenario]") {
  check_lifted("hand_hidden", 1.0);
}

TEST_CASE("who stands before the object is asked to step aside, and nothing moves", "[scenario]") {
  auto config = control::run_defaults();
  config.task.partner_timeout_s = 8.0;
  const auto lift = run("hand_never_seen", control::Method::Fast, config);
  CHECK(lift.record.outcome == Result::Refused);
  CHECK_FALSE(passed(lift, Task::Approach));
  REQUIRE(lift.record.intents.size() == 1);
  CHECK(lift.record.intents[0].says.find("please step to the left, as the camera sees it") == 0);
  CHECK(lift.record.reason.find("of the object's edge from the camera") != std::string::npos);
}

TEST_CASE("who steps aside when he is asked to is seen, and the object is lifted with him", "[scenario]") {
  const auto lift = run("steps_aside");
  INFO(tests::line("steps_aside", lift));
  CHECK(lift.record.outcome == Result::Lifted);
  REQUIRE(!lift.record.intents.empty());
  CHECK(lift.record.intents[0].says.find("please step to the left, as the camera sees it") == 0);
}

TEST_CASE("who raises his end a little is known to hold it, though his hand is never seen", "[scenario]") {
  const auto lift = run("raises_his_end");
  INFO(tests::line("raises_his_end", lift));
  CHECK(lift.record.outcome == Result::Lifted);
  REQUIRE(!lift.record.intents.empty());
  CHECK(lift.record.intents[0].says.find("or raise the object there") != std::string::npos);
  const auto decided = std::ranges::find(lift.record.states, Task::Decide, &control::StateChange::state);
  REQUIRE(decided != lift.record.states.end());
  CHECK(decided->reason.find("behind his body, and stands again") != std::string::npos);
}

TEST_CASE("where the best place is out of reach, the next best is taken", "[scenario]") {
  check_lifted("unreachable_optimum", 3.0);
}

TEST_CASE("a hand comes at an angle where the elbow could not bend enough for a straight one", "[scenario]") {
  check_lifted("near_table", 2.0);
}

TEST_CASE("who takes the robot's own side of the object is told why that cannot be", "[scenario]") {
  // he leans against the arm at rest, which yields
  const auto touched = run("partner_near_robot");
  CHECK(touched.record.outcome == Result::Aborted);
  CHECK(touched.record.reason.find("yielded to unexpected force") != std::string::npos);
  CHECK_FALSE(passed(touched, Task::Approach));

  control::Config config = control::run_defaults();
  config.monitor.force.on = false;
  const auto lift = run("partner_near_robot", control::Method::Fast, config);
  CHECK(lift.record.outcome == Result::Refused);
  CHECK(lift.record.reason.find("the object would tip") != std::string::npos);
  CHECK(lift.record.reason.find("beyond the reach of the hand") != std::string::npos);
  CHECK_FALSE(passed(lift, Task::Approach));
}

TEST_CASE("a partner in the middle of the object leaves nothing to share", "[scenario]") {
  // the robot takes an end and bears next to nothing, or it is refused; in no case does the object tip
  const auto lift = run("box_partner_middle");
  INFO(tests::line("box_partner_middle", lift));
  CHECK_FALSE(lift.hit_something);
  CHECK_FALSE(lift.record.hand_keeps_grip);
  if (lift.record.outcome == Result::Lifted)
    CHECK(lift.tilt_deg < 2.0);
  else
    CHECK(lift.record.outcome == Result::Refused);
}

TEST_CASE("same scenario and seed give the same lift, bit for bit", "[scenario]") {
  const tests::SimulatedLift& a = lift_of_table();
  const tests::SimulatedLift b = run("table");
  REQUIRE(a.record.curve.size() == b.record.curve.size());
  for (std::size_t i = 0; i < a.record.curve.size(); ++i)
    REQUIRE(a.record.curve[i].load_n == b.record.curve[i].load_n);
  CHECK(a.tilt_deg == b.tilt_deg);
  CHECK(a.share_robot == b.share_robot);
}

TEST_CASE("the thesis's method lifts what shows it a narrow face within reach", "[scenario][thesis]") {
  if (!control::make_pipeline(control::Method::Thesis)) return;  // not in this build
  // the top of the box, and from beside the robot the near rim of the table
  for (const char* name : {"box", "table_side_camera"}) {
    if (name != std::string_view("box") && !tests::thorough()) continue;  // its point clouds take a while
    const auto lift = run(name, control::Method::Thesis);
    INFO(tests::line(name, lift));
    REQUIRE(lift.record.outcome == Result::Lifted);
    CHECK(lift.tilt_deg < 2.0);
    CHECK(std::abs(lift.share_robot - 0.5) < 0.1);
    CHECK(lift.partner_error_m < 0.1);
    CHECK_FALSE(lift.hit_something);
    CHECK_FALSE(lift.record.hand_keeps_grip);
    // a dwell is made of as many sightings as its chain has the time for
    CHECK(reason_for(lift, Task::Decide).find("3 frames") != std::string::npos);
  }
}

TEST_CASE("opposite to the robot the thesis's method sees no face within reach", "[scenario][thesis]") {
  if (!control::make_pipeline(control::Method::Thesis)) return;  // not in this build
  for (const char* name : {"table", "table_pose_2"}) {
    if (name != std::string_view("table") && !tests::thorough()) continue;
    const auto lift = run(name, control::Method::Thesis);
    INFO(tests::line(name, lift));
    CHECK(lift.record.outcome == Result::Refused);
    CHECK(lift.record.reason.find("out of the arm's reach") != std::string::npos);
    CHECK_FALSE(passed(lift, Task::Approach));
  }
}
