// What a person puts where it does not belong: fingers between palm and object, a foot under the object.

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <string>

#include "tests/support/fault_table.hpp"
#include "tests/support/thorough.hpp"
#include "tools/experiments/runs/faulty_lift.hpp"
#include "tools/experiments/runs/people_scene.hpp"
#include "tools/experiments/runs/thing_between.hpp"
#include "tools/experiments/runs/whole_lift.hpp"
#include "tools/experiments/trials/layouts.hpp"

namespace {

using namespace colift;
using namespace colift::experiments;
using control::Task;

constexpr std::uint64_t kSeed = 41;
const int kLayouts = tests::thorough() ? 4 : 3;

/// The nth layout of the people experiment, where somebody does this once the job is in a state.
sim_hal::Scenario scene(PeopleScene what, int nth, Task in, double after_s) {
  Trial trial;
  trial.seed = kSeed;
  trial.index = static_cast<int>(kPeopleScenes.size()) * nth + static_cast<int>(what);
  sim_hal::Scenario scenario = people_trial(trial).scenario;
  scenario.people[0].in_state = control::word(in);
  scenario.people[0].enters_s = after_s;
  return scenario;
}

struct Told {
  WholeLift lift;
  double most_n = 0.0;  ///< On him, by robot or object.
};

Told tell(const sim_hal::Scenario& scenario) {
  auto lift = run_whole_lift(scenario, control::Method::Fast, kSeed);
  REQUIRE(lift);
  Told out{std::move(*lift), 0.0};
  for (const auto& c : out.lift.verdict.contacts) out.most_n = std::max(out.most_n, c.force_n);
  return out;
}

std::string words(const Told& t) {
  std::string out = t.lift.record.reason + fmt::format("; {:.0f} N at most", t.most_n);
  for (const auto& s : t.lift.record.states)
    out += fmt::format("\n{:.2f} {}: {}", hal::seconds(s.at), control::word(s.state), s.reason);
  for (const auto& f : t.lift.record.faults)
    out += fmt::format("\n{:.2f} {}: {}", hal::seconds(f.at), f.device, f.what);
  for (const auto& c : t.lift.verdict.contacts)
    out += fmt::format("\ntouched at {:.2f} s: {} by {}, {:.0f} N, for {:.2f} s", c.t_s, c.region, c.by,
                       c.force_n, c.clamped_s);
  return out;
}

}  // namespace

TEST_CASE("hands and feet in the way here", "[.fault-table]") {
  tests::print_fault("16 something between palm and object", Task::Close, true);
  tests::print_fault("24 object meets something", Task::Lower, true);
}

TEST_CASE("fingers that are between palm and object are never gripped on, and not squeezed (row 16)") {
  for (int nth = 0; nth < kLayouts; ++nth) {
    if (!tests::chosen(0, nth)) continue;
    const Told told = tell(scene(PeopleScene::HandInFingers, nth, Task::Close, 0.0));
    INFO(nth << ": " << words(told));
    CHECK(fmt::format("{}", fmt::join(told.lift.verdict.breaches, "; ")) == "");
  }
}

TEST_CASE("a thing under a finger that wraps a pipe is felt over the hand's real driver, too (row 16)") {
  // of pads that pinch something hands see more; of fingers around a bar only the angles at which they stop
  constexpr Under place = Under::F2;
  // the first pipe beside whose grasp there is room for it, and that is gripped there with it, too
  int gripped = 0;
  for (int pipe = 0; pipe < 6 && gripped == 0; ++pipe) {
    Trial trial;
    trial.seed = 13;
    trial.index = 4 * pipe + 2;
    const std::uint64_t seed = trial.own_seed(51);
    sim_hal::Scenario scenario = mixed_layout(trial.index, trial.seed);
    LiftHooks until_gripped;
    until_gripped.cut.at = {Task::AwaitReady};
    const auto alone = run_whole_lift(scenario, control::Method::Fast, seed, until_gripped);
    REQUIRE(alone);
    const FirstGrip grip = first_grip(alone->record);
    if (!grip.grasp || !grip.accepted || grip.grasp->kind != planner::GraspKind::Wrap) continue;
    const auto thing =
        thing_between(*grip.grasp, shared_hand(control::Method::Fast).hand, place, grip.close_s);
    if (!thing) continue;
    scenario.clutter.push_back(*thing);
    const auto lift = run_faulty_lift({scenario, Wire::Hand, {}}, config_for(control::Method::Fast, {}),
                                      control::Method::Fast, seed);
    REQUIRE(lift);
    const FirstGrip between = first_grip(lift->record);
    if (!between.grasp) continue;
    ++gripped;
    INFO(pipe << ", " << word(place) << ": " << between.why << "; " << lift->record.reason);
    CHECK(lift->failed == "");
    CHECK_FALSE(between.accepted);
    CHECK_THAT(between.why,
               Catch::Contains(fmt::format("something is between {} and the object", word(place))));
    CHECK(fmt::format("{}", fmt::join(lift->verdict.breaches, "; ")) == "");
    CHECK(fmt::format("{}", fmt::join(lift->broken_rules, "; ")) == "");
  }
  CHECK(gripped == 1);
}

TEST_CASE("who reaches under the object with his foot is not touched, whatever the state") {
  constexpr std::array kStates{Task::Lift, Task::Hold, Task::Lower};
  const std::size_t state = GENERATE(0, 1, 2);
  const Task in = kStates[state];
  for (int nth = 0; nth < kLayouts; ++nth) {
    if (!tests::chosen(state, nth)) continue;
    const Told told = tell(scene(PeopleScene::FootUnder, nth, in, 0.0));
    INFO(control::word(in) << ", " << nth << ": " << words(told));
    CHECK(fmt::format("{}", fmt::join(told.lift.verdict.breaches, "; ")) == "");
    CHECK(told.most_n <= 65.0);
  }
}

TEST_CASE("a thing that somebody has pushed under the raised object ends its way down (row 24)") {
  auto scenario = sim_hal::load_scenario(std::string(COLIFT_SOURCE_DIR) + "/config/scenario/table.yaml");
  REQUIRE(scenario);
  sim_hal::ScenarioClutter slab;
  slab.size = {0.16, 0.16, 0.03};
  slab.xyz = {0.79, 1.4, 0.0};
  // under the leg beside the hand, while the table is held up by 5 cm
  slab.moves = {{13.5, {0.682, 0.237, 0.0}, 2.0}};
  scenario->clutter.push_back(slab);
  auto lift = run_whole_lift(*scenario, control::Method::Fast, 1);
  REQUIRE(lift);
  const Told told{std::move(*lift), 0.0};
  INFO(words(told));
  CHECK(fmt::format("{}", fmt::join(told.lift.verdict.breaches, "; ")) == "");
  CHECK(told.lift.record.outcome == control::RunRecord::Result::Aborted);
  CHECK(told.lift.record.states.back().state == Task::Stopped);
  CHECK_THAT(told.lift.record.reason, Catch::Contains("the grip stays closed") && Catch::Contains("mm up"));
  for (const auto& s : told.lift.record.states) CHECK(s.state != Task::Release);
}
