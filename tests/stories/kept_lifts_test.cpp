// Lifts that once went wrong, as `colift experiment people` and `false-stops` kept them:
// tests/data/kept_lifts.

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <fstream>
#include <optional>
#include <string>

#include "hal/robot_model/robot_model.hpp"
#include "tests/support/thorough.hpp"
#include "tools/experiments/runs/body_in_view.hpp"
#include "tools/experiments/runs/whole_lift.hpp"

namespace {

using namespace colift;
using namespace colift::experiments;

constexpr const char* kFolder = COLIFT_SOURCE_DIR "/tests/data/kept_lifts/";

/// A kept lift made once more, and what the arm did after somebody pushed it.
struct KeptRun {
  WholeLift lift;
  bool rested = false;    ///< When he touched it.
  double rise_m = 0.0;    ///< Of the palm, since the job's Yield began.
  double moving_s = 0.0;  ///< After the end of the last touch: until no joint was faster than 0.1 rad/s.
};

std::uint64_t seed_in(const std::string& file) {
  std::ifstream in(file);
  std::string line;
  REQUIRE(std::getline(in, line));
  const std::size_t at = line.find("--seed ");
  REQUIRE(at != std::string::npos);
  return std::stoull(line.substr(at + 7));
}

KeptRun run_kept(const std::string& name, const Settings& settings = {}) {
  const std::string file = kFolder + name + ".yaml";
  const auto scenario = sim_hal::load_scenario(file);
  REQUIRE(scenario);
  KeptRun out;
  std::optional<BodyInView> view;
  bool yields = false;
  std::optional<double> from_m;
  double touched_s = 0.0;
  LiftHooks hooks;
  hooks.settings = settings;
  hooks.started = [&](const sim_hal::SimWorld& world) { view.emplace(world); };
  hooks.each_frame = [&](const sim_hal::SimWorld&, control::Task task) {
    yields = yields || task == control::Task::Yield;
  };
  hooks.each_tick = [&](const sim_hal::TickReport& report) {
    view->tick(report);
    if (!report.contacts.empty()) touched_s = report.t_s;
    if (!yields) return;
    const double palm_m = hal::hand_pose(hal::built_in_robot(), report.truth.q_rad).translation().z();
    if (!from_m) from_m = palm_m;
    out.rise_m = std::max(out.rise_m, palm_m - *from_m);
    if (report.dq_rad_s.cwiseAbs().maxCoeff() > 0.1) out.moving_s = report.t_s - touched_s;
  };
  auto lift = run_whole_lift(*scenario, control::Method::Fast, seed_in(file), hooks);
  REQUIRE(lift);
  out.lift = std::move(*lift);
  out.rested = view->rested();
  return out;
}

std::string told(const KeptRun& run) {
  std::string all = run.lift.record.reason;
  for (const auto& s : run.lift.record.states)
    all += fmt::format("\n{:.2f} {}: {}", hal::seconds(s.at), control::word(s.state), s.reason);
  return all;
}

}  // namespace

TEST_CASE("who knocks the load out of the hand does not make the arm fly up") {
  const KeptRun run = run_kept("run_knocks_the_load_out");
  INFO(told(run));
  CHECK(fmt::format("{}", fmt::join(run.lift.verdict.breaches, "; ")) == "");
  CHECK(run.rested);
  CHECK(run.rise_m < 0.35);  // 1 m before
  CHECK(run.moving_s < 1.0);
  CHECK_THAT(run.lift.record.reason, Catch::Matchers::Contains("the load is gone from the hand"));
}

TEST_CASE("an arm that was pushed aside does not come back at who pushed it") {
  const KeptRun run = run_kept("crouch_pushes_again_and_again");
  INFO(told(run));
  CHECK(fmt::format("{}", fmt::join(run.lift.verdict.breaches, "; ")) == "");
  for (const sim_hal::JudgedContact& c : run.lift.verdict.contacts) {
    INFO(c.t_s << " s: " << c.region << ", " << c.force_n << " N");
    CHECK(c.his_own);
  }
}

TEST_CASE("a partner who holds on is not said to let go") {
  constexpr std::array kNames{
      "chair_turns_about_its_feet",      "box_pressed_down_by_the_grip",        "chair_hides_his_hand",
      "chair_lifted_hand_moves_7_sigma", "chair_set_down_turns_about_its_feet", "light_chair_sways"};
  for (std::size_t n = 0; n < kNames.size(); ++n) {
    if (n % 2 != 0 && !tests::thorough()) continue;
    const char* const name = kNames[n];
    const KeptRun run = run_kept(name);
    INFO(name << "\n" << told(run));
    CHECK(run.lift.record.outcome == control::RunRecord::Result::Lifted);
    for (const auto& s : run.lift.record.states) CHECK(s.state != control::Task::Pause);
  }
}

TEST_CASE("what no generator of objects draws is carried, whatever the partner does meanwhile") {
  constexpr std::array kNames{"stretcher",           "frame_on_feet",
                              "he_lowers_first",     "trestle",
                              "table_on_one_foot",   "pipe_out_of_straight_reach",
                              "hand_before_his_body"};
  for (std::size_t n = 0; n < kNames.size(); ++n) {
    if (n % 2 != 0 && !tests::thorough()) continue;
    const KeptRun run = run_kept(kNames[n]);
    INFO(kNames[n] << "\n" << told(run));
    CHECK(run.lift.record.outcome == control::RunRecord::Result::Lifted);
    CHECK(fmt::format("{}", fmt::join(run.lift.verdict.breaches, "; ")) == "");
  }
}

TEST_CASE("an object that slid in the hand stands sooner than it was grasped, and is let go there") {
  // with fingers that close behind the bar
  const KeptRun run = run_kept("smooth_chair_slides_in_the_hand", {{"candidates.measure_depth", "false"}});
  INFO(told(run));
  CHECK(fmt::format("{}", fmt::join(run.lift.verdict.breaches, "; ")) == "");
  CHECK(run.lift.record.states.back().state == control::Task::Aborted);  // at home, not stopped around it
  CHECK_THAT(run.lift.record.reason, Catch::Matchers::Contains("mm in the hand (limit 20)"));
  for (const auto& s : run.lift.record.states) CHECK(s.state != control::Task::Pause);
}

TEST_CASE("a chair does not slide where the pads press on its bar instead of behind it") {
  const KeptRun run = run_kept("chair_slides_in_the_hand");
  INFO(told(run));
  CHECK(run.lift.record.outcome == control::RunRecord::Result::Lifted);
  CHECK(run.lift.slip_m < 0.005);
}

TEST_CASE("a partner who comes near before the arm moves makes it start later, and stops nothing") {
  const KeptRun run = run_kept("he_still_moves_at_the_start");
  INFO(told(run));
  CHECK(run.lift.record.outcome == control::RunRecord::Result::Lifted);
  CHECK(run.lift.record.monitor.stops == 0);
  CHECK(run.lift.record.monitor.waited_s < 0.8);
}

TEST_CASE("a lift stands before who walks in is there") {
  const KeptRun run = run_kept("walks_into_a_lift");
  INFO(told(run));
  CHECK(fmt::format("{}", fmt::join(run.lift.verdict.breaches, "; ")) == "");
  CHECK(run.rested);
}

TEST_CASE("an open hand that meets a side of a shelf that nobody sees goes back, and grasps elsewhere") {
  const KeptRun run = run_kept("hidden_side_of_a_shelf");
  INFO(told(run));
  CHECK(fmt::format("{}", fmt::join(run.lift.verdict.breaches, "; ")) == "");
  const auto& states = run.lift.record.states;
  const auto met = std::find_if(states.begin(), states.end(),
                                [](const auto& s) { return s.state == control::Task::Contact; });
  REQUIRE(met != states.end());
  REQUIRE(std::next(met) != states.end());
  CHECK(std::next(met)->state == control::Task::Retreat);
  CHECK(run.lift.record.outcome == control::RunRecord::Result::Lifted);
}

TEST_CASE("a shelf that hangs askew comes down on an edge, and is let go to settle on its feet") {
  const KeptRun run = run_kept("shelf_down_on_an_edge");
  INFO(told(run));
  CHECK(fmt::format("{}", fmt::join(run.lift.verdict.breaches, "; ")) == "");
  CHECK(run.lift.record.outcome == control::RunRecord::Result::Lifted);
}

TEST_CASE("a shelf that hangs askew is not let go on a thing that was pushed under it") {
  const KeptRun run = run_kept("thing_under_an_askew_shelf");
  INFO(told(run));
  CHECK(run.lift.record.states.back().state == control::Task::Stopped);
  CHECK(run.lift.record.hand_keeps_grip);
  for (const auto& s : run.lift.record.states) CHECK(s.state != control::Task::Release);
}

TEST_CASE("a partner who holds his end lower after a stumble has not let it fall") {
  KeptRun run = run_kept("holds_lower_after_a_stumble");
  INFO(told(run));
  CHECK(fmt::format("{}", fmt::join(run.lift.verdict.breaches, "; ")) == "");
  CHECK(run.lift.record.outcome == control::RunRecord::Result::Lifted);
}

TEST_CASE("a lift that is interrupted too often is set down together") {
  const KeptRun run = run_kept("holds_lower_after_a_stumble", {{"task.carry.max_regrasps", "0"}});
  INFO(told(run));
  CHECK(fmt::format("{}", fmt::join(run.lift.verdict.breaches, "; ")) == "");
  CHECK(run.lift.record.outcome == control::RunRecord::Result::Aborted);
  CHECK_THAT(run.lift.record.reason, Catch::Matchers::Contains("the lift was interrupted once"));
  CHECK(run.lift.record.states.back().state == control::Task::Aborted);
}

TEST_CASE("who lets go millimetres above the ground has not lowered it: set down, and not called lifted") {
  const KeptRun run = run_kept("lets_go_right_above_the_ground");
  INFO(told(run));
  CHECK(fmt::format("{}", fmt::join(run.lift.verdict.breaches, "; ")) == "");
  CHECK(run.lift.record.outcome == control::RunRecord::Result::Aborted);
  CHECK(run.lift.record.states.back().state == control::Task::Aborted);
  CHECK_THAT(run.lift.record.reason, Catch::Matchers::Contains("the partner let go before the object stood"));
}

TEST_CASE("fingers that met a side under a plate take the rim less deep") {
  const KeptRun run = run_kept("plate_over_a_recessed_body");
  INFO(told(run));
  CHECK(fmt::format("{}", fmt::join(run.lift.verdict.breaches, "; ")) == "");
  const auto& states = run.lift.record.states;
  const auto entered = [&](control::Task task) {
    return std::count_if(states.begin(), states.end(), [&](const auto& s) { return s.state == task; });
  };
  CHECK(entered(control::Task::Close) == 2);
  CHECK(entered(control::Task::AwaitReady) == 1);
}
