// Whole lifts with people beside the partner: the arm slows, waits and continues, or ends with a reason.

#include <algorithm>
#include <catch2/catch.hpp>
#include <string>

#include "control/config/arm_mode.hpp"
#include "sim_hal/scenario/scenario.hpp"
#include "tests/support/fault_table.hpp"
#include "tests/support/simulated_lift.hpp"

namespace {

using namespace colift;
using control::Task;
using Result = control::RunRecord::Result;

sim_hal::Scenario shipped(const std::string& name) {
  auto scenario =
      sim_hal::load_scenario(std::string(COLIFT_SOURCE_DIR) + "/config/scenario/" + name + ".yaml");
  REQUIRE(scenario);
  return *scenario;
}

sim_hal::Scenario table() {
  return shipped("table");
}

sim_hal::ScenarioPerson somebody(double enters_s, std::vector<Eigen::Vector2d> path,
                                 const std::string& action, std::optional<double> leaves_s) {
  sim_hal::ScenarioPerson p;
  p.enters_s = enters_s;
  p.path = std::move(path);
  p.action = action;
  p.leaves_s = leaves_s;
  return p;
}

tests::SimulatedLift lift_with(const sim_hal::ScenarioPerson& person,
                               control::Config config = control::run_defaults()) {
  sim_hal::Scenario scenario = table();
  scenario.people.push_back(person);
  return tests::simulate(scenario, control::Method::Fast, 1, std::move(config));
}

/// Nobody but the partner is there.
const tests::SimulatedLift& alone() {
  static const tests::SimulatedLift lift = tests::simulate(table(), control::Method::Fast, 1);
  return lift;
}

double entered_s(const tests::SimulatedLift& lift, Task task) {
  for (const control::StateChange& s : lift.record.states)
    if (s.state == task) return hal::seconds(s.at);
  return -1.0;
}

/// When the monitor noted something that begins so for the first time; -1: never.
double noted_s(const tests::SimulatedLift& lift, const std::string& begin) {
  for (const control::DeviceNote& f : lift.record.faults)
    if (f.what.starts_with(begin)) return hal::seconds(f.at);
  return -1.0;
}

std::string told(const tests::SimulatedLift& lift) {
  std::string out = lift.record.reason;
  for (const control::DeviceNote& f : lift.record.faults)
    out += "\n" + std::to_string(hal::seconds(f.at)) + " " + f.device + ": " + f.what;
  return out;
}

}  // namespace

TEST_CASE("the people who are in the way here", "[.fault-table]") {
  for (const control::Task in : {control::Task::Approach, control::Task::Lift})
    tests::print_fault("15 a person in the path", in, true);
}

TEST_CASE("who stands in the path stops the arm; when he has gone, the lift continues") {
  const auto lift =
      tests::simulate(shipped("person_in_the_path"), control::Method::Fast, 1, control::run_defaults());
  INFO(told(lift));
  CHECK(lift.record.outcome == Result::Lifted);
  CHECK(lift.record.monitor.stops >= 1);
  CHECK(lift.record.monitor.waited_s > 3.0);
  CHECK(entered_s(lift, Task::Close) > 10.0);
  CHECK(lift.person_contacts == 0);
}

TEST_CASE("what is put into the path and stays there is planned around (row 51)") {
  const auto lift =
      tests::simulate(shipped("box_in_the_path"), control::Method::Fast, 1, control::run_defaults());
  INFO(told(lift));
  CHECK(lift.record.outcome == Result::Lifted);
  CHECK(lift.record.monitor.stops >= 1);
  CHECK(entered_s(lift, Task::BackOff) > 0.0);
  CHECK_FALSE(lift.hit_something);
}

TEST_CASE(
    "what is put into the path before the first plan is planned around, and never stopped for (row 51)") {
  sim_hal::Scenario scenario = shipped("box_in_the_path");
  scenario.clutter[0].moves[0].at_s = 0.6;  // the scene was seen, the partner comes at 3 s
  const auto lift = tests::simulate(scenario, control::Method::Fast, 1, control::run_defaults());
  INFO(told(lift));
  CHECK(lift.record.outcome == Result::Lifted);
  CHECK(lift.record.monitor.stops == 0);
  CHECK_FALSE(lift.hit_something);
}

TEST_CASE("what is carried off before the plan is no obstacle (row 51)") {
  sim_hal::Scenario scenario = shipped("box_in_the_path");
  auto& box = scenario.clutter[0];
  const hal::Vec3 away = box.xyz;
  box.xyz = box.moves[0].to;  // where no path is, as long as it stands there
  const bool carried_off = GENERATE(true, false);
  box.moves[0].to = away;
  box.moves[0].at_s = 0.6;
  if (!carried_off) box.moves.clear();
  const auto lift = tests::simulate(scenario, control::Method::Fast, 1, control::run_defaults());
  INFO(told(lift));
  const auto& states = lift.record.states;
  const auto looks = std::count_if(states.begin(), states.end(),
                                   [](const control::StateChange& s) { return s.state == Task::Observe; });
  CHECK(looks == (carried_off ? 2 : 1));  // so much of the view that the partner would not be recognised
  if (carried_off) {
    CHECK(lift.record.outcome == Result::Lifted);
    CHECK(lift.record.monitor.stops == 0);
  }
  CHECK_FALSE(lift.hit_something);
}

TEST_CASE("who stays in the path: the lift ends safely, with the reason, and nobody is touched") {
  control::Config config = control::run_defaults();
  config.task.attempts.max_approaches = 2;
  config.monitor.max_wait_s = 10.0;  // he does not go
  const auto lift = lift_with(somebody(3.5, {{0.3, -2.4}, {0.3, -0.95}}, "stand", std::nullopt), config);
  INFO(told(lift));
  CHECK(lift.record.outcome == Result::Aborted);
  CHECK(lift.record.reason.find("from the arm") != std::string::npos);
  CHECK(lift.person_contacts == 0);
  CHECK(entered_s(lift, Task::Close) < 0.0);
}

// The arm stops three times, the last time within the half second before the hand closes, whose announcement
// must not keep that of the arm's continuation from being made.
TEST_CASE("who steps in and out of the path three times is waited for, and the lift goes on") {
  std::vector<Eigen::Vector2d> path{{0.3, -4.0}};
  for (int i = 0; i < 3; ++i) path.insert(path.end(), {{0.3, -1.1}, {0.3, -4.0}});
  const auto lift = lift_with(somebody(1.0, path, "walk", std::nullopt));
  INFO(told(lift));
  CHECK(lift.record.outcome == Result::Lifted);
  CHECK(lift.record.monitor.stops == 3);
  CHECK(lift.record.intents.size() < 20);
  CHECK(lift.person_contacts == 0);
}

TEST_CASE("who steps in and out of the path again and again does not keep the arm for ever") {
  control::Config config = control::run_defaults();
  config.monitor.max_wait_s = 3.5;         // at a stretch, which he never stays
  config.motion.velocity_fraction *= 0.2;  // so that he comes often enough
  std::vector<Eigen::Vector2d> path{{0.5, -4.0}};
  for (int i = 0; i < 12; ++i) path.insert(path.end(), {{0.5, -0.95}, {0.5, -4.0}});
  const auto lift = lift_with(somebody(1.0, path, "walk", std::nullopt), config);
  INFO(told(lift));
  CHECK(lift.record.outcome == Result::Aborted);
  CHECK(lift.record.reason.find("in all, for whoever came near again and again") != std::string::npos);
  CHECK(lift.record.monitor.stops >= 3);
  CHECK(lift.person_contacts == 0);
}

TEST_CASE("who runs in at 1.6 m/s meets an arm that is at rest") {
  sim_hal::ScenarioPerson runner = somebody(4.0, {{1.2, -2.5}, {0.6, -0.8}}, "stand", 10.0);
  runner.speed = 1.6;
  const auto lift = lift_with(runner);
  INFO(told(lift));
  CHECK(lift.record.outcome == Result::Lifted);
  CHECK(lift.record.monitor.stops >= 1);
  CHECK(lift.person_contacts == 0);
}

TEST_CASE("who crouches at the grasp stops the arm before it is there") {
  const auto lift = lift_with(somebody(3.6, {{0.2, -2.0}, {0.6, -0.75}}, "crouch", 11.0));
  INFO(told(lift));
  CHECK(lift.record.outcome == Result::Lifted);
  CHECK(entered_s(lift, Task::Close) > 11.0);
  CHECK(lift.person_contacts == 0);
}

TEST_CASE("who comes near the raised object is waited for, with the object held") {
  const auto lift = lift_with(somebody(12.0, {{0.5, -2.4}, {0.5, -0.8}}, "stand", 19.0));
  INFO(told(lift));
  CHECK(lift.record.outcome == Result::Lifted);
  CHECK(entered_s(lift, Task::Release) > 19.0);  // not lowered beside him
  CHECK(lift.person_contacts == 0);
}

// ---- a stop after which an operator confirms: monitor.resume=false ----

TEST_CASE("after a stop an operator confirms: announced and continued then, and not before") {
  control::Config config = control::run_defaults();
  config.monitor.resume = false;
  sim_hal::Scenario scenario = shipped("person_in_the_path");
  // before the stop, while he stands there, and when he has gone
  for (const double at_s : {3.0, 8.0, 16.0})
    scenario.partner.events.push_back({at_s, "confirm-continue", {}});
  const auto lift = tests::simulate(scenario, control::Method::Fast, 1, config);
  INFO(told(lift));
  CHECK(lift.record.outcome == Result::Lifted);
  CHECK(lift.record.monitor.stops == 1);
  CHECK(noted_s(lift, "waits for confirmation: nobody is near any more") > 9.0);
  CHECK(noted_s(lift, "waits for confirmation") < 14.0);
  const double confirmed_s = noted_s(lift, "an operator confirmed"),
               on_s = noted_s(lift, "the arm continues");
  CHECK(confirmed_s == Approx(16.0).margin(0.1));
  CHECK(on_s == Approx(confirmed_s + config.task.intent_lead_s).margin(0.05));
  CHECK(std::any_of(lift.record.intents.begin(), lift.record.intents.end(), [&](const control::Intent& i) {
    return i.motion == control::Motion::Continue && std::abs(hal::seconds(i.at) - confirmed_s) < 0.05;
  }));
  CHECK(lift.person_contacts == 0);
}

TEST_CASE(
    "a stop that nobody confirms: the arm holds its position, with the reason, after the longest wait") {
  control::Config config = control::run_defaults();
  config.monitor.resume = false;
  config.monitor.max_wait_s = 10.0;
  const auto lift =
      tests::simulate(shipped("person_in_the_path"), control::Method::Fast, 1, std::move(config));
  INFO(told(lift));
  CHECK(lift.record.states.back().state == Task::Stopped);
  CHECK_THAT(lift.record.reason,
             Catch::Contains("timeout: nobody confirmed that the arm may continue; holds"));
  CHECK(entered_s(lift, Task::Stopped) ==
        Approx(noted_s(lift, "waits for confirmation") + 10.0).margin(0.1));  // he had gone before
  CHECK(entered_s(lift, Task::Close) < 0.0);
  CHECK(lift.person_contacts == 0);
}

TEST_CASE("who comes back after the confirmation stops the arm again, and it is confirmed again") {
  control::Config config = control::run_defaults();
  config.monitor.resume = false;
  sim_hal::Scenario scenario = table();
  scenario.people.push_back(somebody(3.5, {{0.3, -2.4}, {0.3, -0.95}}, "stand", 6.0));
  // walks in as the first confirmation is announced
  scenario.people.push_back(somebody(9.0, {{0.3, -2.4}, {0.3, -0.95}}, "stand", 14.0));
  for (const double at_s : {9.6, 20.0}) scenario.partner.events.push_back({at_s, "confirm-continue", {}});
  const auto lift = tests::simulate(scenario, control::Method::Fast, 1, std::move(config));
  INFO(told(lift));
  CHECK(lift.record.outcome == Result::Lifted);
  CHECK(std::count_if(lift.record.faults.begin(), lift.record.faults.end(),
                      [](const auto& f) { return f.what.starts_with("an operator confirmed"); }) == 2);
  CHECK(entered_s(lift, Task::Close) > 20.0);
  CHECK(lift.person_contacts == 0);
}

TEST_CASE(
    "an arm that waits for a confirmation does not continue because the camera is lost, nor asks then") {
  control::Config config = control::run_defaults();
  config.monitor.resume = false;
  sim_hal::Scenario scenario = table();
  scenario.people.push_back(somebody(10.0, {{0.5, -2.4}, {0.5, -0.8}}, "stand", 15.0));
  scenario.faults.push_back({22.0, "camera", "unplug", 5.0});
  for (const double at_s : {25.0, 32.0}) scenario.partner.events.push_back({at_s, "confirm-continue", {}});
  const auto lift = tests::simulate(scenario, control::Method::Fast, 1, std::move(config));
  INFO(told(lift));
  CHECK(lift.record.outcome == Result::Lifted);
  CHECK(noted_s(lift, "waits for confirmation") < 22.0);
  CHECK(noted_s(lift, "an operator confirmed") == Approx(32.0).margin(0.1));
  CHECK(noted_s(lift, "the arm continues") > 32.0);
  CHECK(lift.person_contacts == 0);
}

TEST_CASE("a confirmation does not continue an arm that was touched") {
  control::Config config = control::run_defaults();
  config.monitor.resume = false;
  sim_hal::Scenario scenario = table();
  scenario.faults.push_back({1.0, "arm", "push", 0.5, 120.0, "", hal::Vec3(0.0, 1.0, 0.0), 0, "approach"});
  for (int at_s = 4; at_s < 20; ++at_s)
    scenario.partner.events.push_back({static_cast<double>(at_s), "confirm-continue", {}});
  const auto lift = tests::simulate(scenario, control::Method::Fast, 1, std::move(config));
  INFO(told(lift));
  CHECK(entered_s(lift, Task::Yield) > 0.0);
  CHECK(lift.record.states.back().state == Task::Stopped);
  CHECK(noted_s(lift, "an operator confirmed") < 0.0);
}

TEST_CASE("who passes far away changes nothing") {
  const auto lift = lift_with(somebody(3.5, {{-1.5, 2.6}, {1.5, 2.8}}, "walk", std::nullopt));
  INFO(told(lift));
  CHECK(lift.record.outcome == Result::Lifted);
  CHECK(lift.record.monitor.stops == 0);
  CHECK(entered_s(lift, Task::Close) == Approx(entered_s(alone(), Task::Close)).margin(0.5));
}

TEST_CASE("without the monitor it is said, and the arm goes at the speed of T1") {
  control::Config config = control::run_defaults();
  config.monitor.on = false;
  const auto lift = tests::simulate(table(), control::Method::Fast, 1, control::for_arm_mode(config));
  CHECK(lift.record.outcome == Result::Lifted);
  CHECK_FALSE(lift.record.monitor.on);
  REQUIRE_FALSE(lift.record.faults.empty());
  CHECK(lift.record.faults.front().device == "monitor");
  CHECK(entered_s(lift, Task::Close) > entered_s(alone(), Task::Close) + 3.0);
}
