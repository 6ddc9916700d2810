// Objects that are heavy where nobody sees it: first a little, slowly, then the lift.

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <string>

#include "sim_hal/scenario/scenario.hpp"
#include "tests/support/lift_figures.hpp"

namespace {

using namespace colift;
using control::Task;
using Result = control::RunRecord::Result;

sim_hal::Scenario heavy_side() {
  const auto scenario =
      sim_hal::load_scenario(std::string(COLIFT_SOURCE_DIR) + "/config/scenario/table_heavy_side.yaml");
  REQUIRE(scenario);
  return *scenario;
}

control::Config tested() {
  control::Config config = control::run_defaults();
  config.test_lift.on = true;
  return config;
}

int times(const tests::SimulatedLift& lift, Task task) {
  return static_cast<int>(std::count_if(lift.record.states.begin(), lift.record.states.end(),
                                        [task](const auto& s) { return s.state == task; }));
}

}  // namespace

TEST_CASE("a table that is heavy on one side is gripped elsewhere, and lifted level", "[tested]") {
  const auto scenario = heavy_side();
  const auto untested = tests::simulate(scenario, control::Method::Fast, 1);
  CHECK((untested.record.outcome != Result::Lifted || untested.tilt_deg > 3.0));

  const auto lift = tests::simulate(scenario, control::Method::Fast, 1, tested());
  INFO(tests::line("table_heavy_side", lift));
  REQUIRE(lift.record.outcome == Result::Lifted);
  CHECK(lift.tilt_deg < 2.0);
  CHECK_FALSE(lift.hit_something);
  CHECK(times(lift, Task::TestLift) >= 2);
  CHECK(times(lift, Task::Lift) == 1);
  REQUIRE(lift.record.test_lifts.size() >= 2);
  const auto& first = lift.record.test_lifts.front();
  const auto& last = lift.record.test_lifts.back();
  CHECK(first.height_m <= 0.031);
  REQUIRE(first.known);
  CHECK(first.known->next == control::TestLift::Next::Regrasp);
  REQUIRE(last.known);
  CHECK(last.known->mass_kg == Approx(4.0).epsilon(0.25));
  // the table was put down a little beside where it had stood, and what was felt went with it
  CHECK((last.known->cog - lift.at_end.cog_W).head<2>().norm() < 0.04);
  CHECK(lift.record.lift->mass_kg == Approx(4.0).epsilon(0.2));
}

TEST_CASE("an even table passes its test lift at once", "[tested]") {
  auto scenario = heavy_side();
  scenario.object.cog_offset.setZero();
  const auto lift = tests::simulate(scenario, control::Method::Fast, 1, tested());
  INFO(tests::line("even table", lift));
  REQUIRE(lift.record.outcome == Result::Lifted);
  CHECK(times(lift, Task::TestLift) == 1);
  CHECK(lift.tilt_deg < 1.0);
}

TEST_CASE("who holds where no grip helps is asked to go elsewhere, and does", "[tested]") {
  auto scenario = heavy_side();
  scenario.object.cog_offset = {0.05, -0.16, 0.0};
  SECTION("and does") {
    const auto lift = tests::simulate(scenario, control::Method::Fast, 1, tested());
    INFO(tests::line("asked", lift));
    CHECK(lift.record.outcome == Result::Lifted);
    CHECK_FALSE(lift.record.asked.empty());
    CHECK(lift.tilt_deg < 2.0);
  }
  SECTION("and stays: the robot goes home and says what it had asked for") {
    scenario.partner.obliging = false;
    auto config = tested();
    config.task.partner_timeout_s = 5.0;
    const auto lift = tests::simulate(scenario, control::Method::Fast, 1, config);
    CHECK(lift.record.outcome == Result::Aborted);
    CHECK(lift.record.asked.size() == 1);
    CHECK(lift.record.reason.find("where he was asked to") != std::string::npos);
    // it stands; he who still holds its overhanging edge may tip it by a degree
    INFO("partner " << lift.at_end.partner_force_W.z() << " N, floor " << lift.at_end.floor_force_W.z()
                    << " N");
    CHECK(lift.at_end.height_m < 0.003);
    CHECK(lift.at_end.floor_force_W.z() > 10.0);
    CHECK_FALSE(lift.record.hand_keeps_grip);
  }
}

TEST_CASE("without a camera no test lift goes on", "[tested]") {
  auto scenario = heavy_side();
  scenario.faults.push_back({12.0, "camera", "freeze", 30.0});
  const auto lift = tests::simulate(scenario, control::Method::Fast, 1, tested());
  CHECK(lift.record.outcome != Result::Lifted);
  CHECK(times(lift, Task::TestLift) == 1);
  CHECK(times(lift, Task::Lift) == 0);
  CHECK(lift.at_end.height_m < 0.002);
}

TEST_CASE("a lift whose bounds are beyond a limit is tried by millimetres first, or refused with the number",
          "[tested]") {
  auto scenario = heavy_side();
  scenario.object.cog_offset.setZero();
  control::Config config = control::run_defaults();
  config.certificate.tilt_factor = 5.0;
  SECTION("tried, which is what a run does by itself") {
    const auto lift = tests::simulate(scenario, control::Method::Fast, 1, config);
    INFO(tests::line("tried first", lift));
    CHECK(lift.record.outcome == Result::Lifted);
    CHECK(times(lift, Task::TestLift) == 1);
  }
  SECTION("refused: nothing moves") {
    config.certificate.on_breach = "refuse";
    const auto lift = tests::simulate(scenario, control::Method::Fast, 1, config);
    CHECK(lift.record.outcome == Result::Refused);
    CHECK(lift.record.reason.find("5.0 are allowed (95 %)") != std::string::npos);
    CHECK(times(lift, Task::Approach) == 0);
  }
}
