// Several cameras on one scene: what a second one adds, and what happens when one fails.

#include <algorithm>
#include <catch2/catch.hpp>
#include <string>
#include <utility>

#include "sim_hal/scenario/scenario.hpp"
#include "tests/support/lift_figures.hpp"

namespace {

using namespace colift;
using control::Task;
using Result = control::RunRecord::Result;

sim_hal::Scenario two_cameras() {
  auto scenario =
      sim_hal::load_scenario(std::string(COLIFT_SOURCE_DIR) + "/config/scenario/two_cameras.yaml");
  REQUIRE(scenario);
  return *scenario;
}

/// The built-in table, which one camera sees well, with a second one beyond the arm's shoulder.
sim_hal::Scenario table_with_two() {
  sim_hal::Scenario scenario = sim_hal::built_in_scenario();
  scenario.more_cameras = two_cameras().more_cameras;
  return scenario;
}

sim_hal::DeviceFaultEvent fault(const std::string& device, const std::string& what, const std::string& state,
                                double after_s, double for_s = 60.0) {
  sim_hal::DeviceFaultEvent f;
  f.device = device;
  f.action = what;
  f.in_state = state;
  f.at_s = after_s;
  f.for_s = for_s;
  return f;
}

tests::SimulatedLift run(const sim_hal::Scenario& scenario,
                         control::Config config = control::run_defaults()) {
  return tests::simulate(scenario, control::Method::Fast, 1, std::move(config));
}

bool says(const tests::SimulatedLift& lift, const std::string& device, const std::string& words) {
  return std::ranges::any_of(lift.record.faults, [&](const control::DeviceNote& note) {
    return note.device == device && note.what.find(words) != std::string::npos;
  });
}

}  // namespace

TEST_CASE("a hand that his body hides from one camera is seen by the other", "[views]") {
  const auto lift = run(two_cameras());
  INFO(tests::line("two_cameras", lift));
  CHECK(lift.record.outcome == Result::Lifted);
  CHECK_FALSE(lift.hit_something);
  REQUIRE(lift.record.views.size() == 2);
  for (const control::ViewReport& view : lift.record.views) {
    INFO(view.reason);
    CHECK(view.used);
    CHECK(view.knows_object);
  }
  CHECK(lift.record.views[1].agreement_m < 0.006);
}

TEST_CASE("a second camera halves the space around the object that nobody sees", "[views]") {
  const auto lift = run(table_with_two());
  INFO(tests::line("table", lift));
  CHECK(lift.record.outcome == Result::Lifted);
  REQUIRE(lift.record.views.size() == 2);
  CHECK(lift.record.unseen < 0.5 * lift.record.views[1].unseen_without);
}

TEST_CASE("when one of two cameras is lost the job continues with the other", "[views]") {
  const std::pair<const char*, const char*> losses[] = {
      {"camera", "await-partner"}, {"camera", "lift"}, {"camera2", "approach"}};
  for (const auto& [camera, state] : losses) {
    sim_hal::Scenario scenario = table_with_two();
    scenario.faults.push_back(fault(camera, "unplug", state, 0.3));
    const auto lift = run(scenario);
    INFO(camera << " unplugged in " << state << ": " << tests::line("table", lift));
    CHECK(lift.record.outcome == Result::Lifted);
    CHECK(says(lift, camera, "unplugged"));
    CHECK(says(lift, "camera", "camera2 leads") == (std::string(camera) == "camera"));
  }
}

TEST_CASE("a camera that is pushed is named within a second, and does not count any more", "[views]") {
  for (const char* camera : {"camera", "camera2"}) {
    sim_hal::Scenario scenario = table_with_two();
    scenario.faults.push_back(fault(camera, "moved", "approach", 0.5, 600.0));
    const auto lift = run(scenario);
    INFO(camera << ": " << tests::line("table", lift));
    CHECK(lift.record.outcome == Result::Lifted);
    REQUIRE(says(lift, camera, "pushed"));
    const auto entered = std::ranges::find(lift.record.states, Task::Approach, &control::StateChange::state);
    REQUIRE(entered != lift.record.states.end());
    for (const control::DeviceNote& note : lift.record.faults)
      if (note.device == camera && note.what.find("pushed") != std::string::npos)
        CHECK(hal::seconds(note.at - entered->at) < 1.5);
  }
}

TEST_CASE("a second camera that stands elsewhere than calibrated is not used", "[views]") {
  sim_hal::Scenario scenario = table_with_two();
  scenario.faults.push_back(fault("camera2", "moved", "", 0.0, 600.0));
  const auto lift = run(scenario);
  INFO(tests::line("table", lift));
  CHECK(lift.record.outcome == Result::Lifted);
  REQUIRE(lift.record.views.size() == 2);
  CHECK_FALSE(lift.record.views[1].used);
  CHECK(says(lift, "camera2", "is not used"));
}
