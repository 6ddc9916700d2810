// Whole lifts in which somebody pushes the arm, or the partner lets go: what is noticed, when, and what the
// job says of itself.

#include <algorithm>
#include <catch2/catch.hpp>
#include <iterator>
#include <string>
#include <vector>

#include "sim_hal/scenario/scenario.hpp"
#include "tests/support/fault_table.hpp"
#include "tests/support/lift_figures.hpp"
#include "tests/support/thorough.hpp"

namespace {

using namespace colift;
using control::Task;
using Result = control::RunRecord::Result;

sim_hal::Scenario scenario(const std::string& name) {
  auto loaded = sim_hal::load_scenario(std::string(COLIFT_SOURCE_DIR) + "/config/scenario/" + name + ".yaml");
  REQUIRE(loaded);
  return *loaded;
}

tests::SimulatedLift run(const sim_hal::Scenario& s,
                         const control::Config& config = control::run_defaults()) {
  return tests::simulate(s, control::Method::Fast, 1, config);
}

/// Nobody pushes, nobody lets go.
const tests::SimulatedLift& lift_of_table() {
  static const tests::SimulatedLift lift = run(scenario("table"));
  return lift;
}

/// When a state was entered (s); of the last time that it was.
double entered(const tests::SimulatedLift& lift, Task task) {
  double at_s = -1.0;
  for (const control::StateChange& s : lift.record.states)
    if (s.state == task) at_s = hal::seconds(s.at);
  return at_s;
}

/// The first state after a time, and when it came.
const control::StateChange* next_state(const tests::SimulatedLift& lift, double after_s) {
  for (const control::StateChange& s : lift.record.states)
    if (hal::seconds(s.at) >= after_s) return &s;
  return nullptr;
}

sim_hal::DeviceFaultEvent push(double at_s, double force_n, const hal::Vec3& direction, double for_s = 1.0) {
  sim_hal::DeviceFaultEvent event{at_s, "arm", "push", for_s};
  event.value = force_n;
  event.direction = direction;
  return event;
}

}  // namespace

TEST_CASE("the forces and let-goes that are injected here", "[.fault-table]") {
  for (const Task in :
       {Task::AwaitPartner, Task::Approach, Task::Close, Task::Lift, Task::Hold, Task::Lower, Task::Retreat})
    tests::print_fault("48 a push of 150 N on the hand", in, true);
  for (const Task in : {Task::Close, Task::Lift, Task::Hold, Task::Lower})
    tests::print_fault("18 a pull of 150 N", in, true);
  for (const Task in : {Task::Lift, Task::Hold, Task::Lower}) tests::print_fault("17 lets go", in, true);
}

TEST_CASE("a push of 150 N on the hand stops the arm in every state, and nothing is called lifted",
          "[force]") {
  const sim_hal::Scenario table = scenario("table");
  const tests::SimulatedLift& nominal = lift_of_table();
  REQUIRE(nominal.record.outcome == Result::Lifted);
  struct Case {
    Task in;
    double force_n;
  };
  const Case cases[] = {Case{Task::AwaitPartner, 150.0}, Case{Task::Approach, 150.0},
                        Case{Task::Close, 150.0},        Case{Task::AwaitReady, 150.0},
                        Case{Task::Lift, 150.0},         Case{Task::Hold, 150.0},
                        Case{Task::Lower, 200.0},        Case{Task::Retreat, 150.0}};
  const hal::Vec3 directions[] = {{0, 1, 0}, {0, 0, 1}, {-1, 0, 0}};
  for (std::size_t k = 0; k < std::size(cases); ++k)
    for (std::size_t d = 0; d < std::size(directions); ++d) {
      if (!tests::chosen(k, d)) continue;
      const Case& c = cases[k];
      const hal::Vec3& direction = directions[d];
      const double at_s = entered(nominal, c.in) + 0.4;
      sim_hal::Scenario s = table;
      s.faults.push_back(push(at_s, c.force_n, direction));
      const tests::SimulatedLift lift = run(s);
      INFO(word(c.in) << " " << direction.transpose() << ": " << lift.record.reason);
      CHECK(lift.record.outcome == Result::Aborted);
      const control::StateChange* next = next_state(lift, at_s);
      REQUIRE(next);
      // beside the object it is a contact at first
      const bool at_object = c.in == Task::Retreat && next->state == Task::Contact;
      CHECK((next->state == Task::Yield || next->state == Task::Pause || at_object));
      CHECK(hal::seconds(next->at) - at_s <= 0.02);
      CHECK(lift.record.states.back().state == Task::Stopped);
    }
}

TEST_CASE("a push before anything is raised opens the hand, and a hand that has lost its object says so",
          "[force]") {
  const sim_hal::Scenario table = scenario("table");
  const tests::SimulatedLift& nominal = lift_of_table();
  for (const Task in : {Task::Close, Task::AwaitReady, Task::Lift}) {
    sim_hal::Scenario s = table;
    s.faults.push_back(push(entered(nominal, in) + 0.4, 150.0, {0, 1, 0}));
    const tests::SimulatedLift lift = run(s);
    INFO(word(in) << ": " << lift.record.reason);
    CHECK(lift.record.states.back().state == Task::Stopped);
    CHECK_FALSE(lift.record.hand_keeps_grip);
    // 150 N for a second also pull the hand off a table that hardly hangs in it yet: it does not say that it
    // keeps its grip then
    CHECK_FALSE(lift.at_end.robot_touches_object);
    // the fingers press on, and close to their stops
    const bool told = lift.record.reason.find("the hand has lost its grip") != std::string::npos;
    CHECK(told == (in == Task::Lift));
  }
}

TEST_CASE("a partner who lets go is noticed, and his lift is never called lifted", "[force]") {
  const char* const names[] = {"table", "box", "chair"};
  const double times_s[] = {0.1, 0.7, 1.5, 3.0, 4.8};
  control::Config impatient = control::run_defaults();
  impatient.task.carry.regrasp_timeout_s = 4.0;  // he does not grasp again
  for (std::size_t n = 0; n < std::size(names); ++n) {
    const char* name = names[n];
    const sim_hal::Scenario nominal = scenario(name);
    for (std::size_t t = 0; t < std::size(times_s); ++t) {
      if (!tests::chosen(n, t)) continue;
      const double into_s = times_s[t];
      sim_hal::Scenario s = nominal;
      s.partner.events.push_back({into_s, "let-go", {}, "lift"});
      const tests::SimulatedLift lift = run(s, impatient);
      const double lift_s = entered(lift, Task::Lift);
      INFO(name << ", " << into_s << " s into the lift: " << lift.record.reason);
      CHECK(lift.record.outcome == Result::Aborted);
      // what still stands when he lets go is released, what hangs never is
      const bool stood = lift.record.reason.find("the object stands") != std::string::npos;
      CHECK(stood == (into_s < 0.5));
      CHECK(lift.record.states.back().state == (stood ? Task::Aborted : Task::Stopped));
      CHECK(lift.record.hand_keeps_grip != stood);
      const control::StateChange* next = next_state(lift, lift_s + into_s);
      REQUIRE(next);
      CHECK(next->state == Task::Pause);
      CHECK(hal::seconds(next->at) - lift_s - into_s <= 0.15);
    }
  }
}

TEST_CASE("a partner who holds again lets the lift continue", "[force]") {
  sim_hal::Scenario s = scenario("table");
  s.partner.obliging = true;
  s.partner.events.push_back({1.5, "let-go", {}, "lift"});
  const tests::SimulatedLift lift = run(s);
  INFO(lift.record.reason);
  CHECK(entered(lift, Task::Lift) > entered(lift, Task::Pause));
  CHECK(lift.record.outcome == Result::Lifted);
  CHECK(lift.tilt_deg < 1.5);
}

TEST_CASE("an object that a partner let go of is lowered only when a person confirms it", "[force]") {
  sim_hal::Scenario s = scenario("box");
  s.partner.events.push_back({0.7, "let-go", {}, "lift"});
  s.partner.events.push_back({1.5, "confirm-lower", {}, "pause"});
  const tests::SimulatedLift lift = run(s);
  INFO(lift.record.reason);
  CHECK(entered(lift, Task::Lower) - entered(lift, Task::Pause) == Approx(1.5).margin(0.02));
  CHECK(entered(lift, Task::Release) > entered(lift, Task::Lower));
  CHECK(lift.record.states.back().state == Task::Aborted);
  CHECK(lift.record.outcome == Result::Aborted);
  CHECK(lift.record.reason.find("confirmed") != std::string::npos);
  CHECK_FALSE(lift.record.hand_keeps_grip);
}

TEST_CASE("a partner who stumbles pulls at the object: the lift pauses, and continues when he stands",
          "[force]") {
  sim_hal::Scenario table = scenario("table");
  sim_hal::PartnerScriptEvent stumble{1.0, "stumble", std::nullopt};
  stumble.in_state = "lift";
  stumble.force_n = 80.0;
  stumble.for_s = 0.4;
  table.partner.events = {stumble};
  const tests::SimulatedLift lift = run(table);
  INFO(tests::line("stumble", lift) << ": " << lift.record.reason);
  const control::StateChange* lifting = nullptr;
  for (const control::StateChange& s : lift.record.states)
    if (!lifting && s.state == Task::Lift) lifting = &s;
  REQUIRE(lifting);
  const auto* pause = next_state(lift, hal::seconds(lifting->at) + 0.001);
  REQUIRE(pause);
  CHECK(pause->state == Task::Pause);
  CHECK(pause->reason.find("pull") != std::string::npos);
  CHECK(hal::seconds(pause->at) - hal::seconds(lifting->at) < 1.2);
  CHECK(lift.record.outcome == Result::Lifted);
}
