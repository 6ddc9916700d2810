// Thesis 6.3.3: the total load, measured by lifting the object with the robot alone.

#include <fmt/format.h>

#include <cmath>
#include <optional>

#include "hal/types/units.hpp"
#include "sim_hal/synthetic/hash_random.hpp"
#include "tools/experiments/bar_plot.hpp"
#include "tools/experiments/experiment.hpp"
#include "tools/experiments/trials/layouts.hpp"
#include "tools/experiments/trials/tried_grasps.hpp"
#include "tools/visualization/palette.hpp"

namespace colift::experiments {
namespace lift_alone_trials {
namespace {

// High enough that the lower end of a box that hangs askew leaves the floor.
constexpr double kHeight_m = 0.10, kHold_s = 2.0;
constexpr double kInAir = 0.98;          // of the weight on the robot: nothing else bears any
constexpr double kThesisMass_kg = 0.41;  // its box: about 4 N
constexpr double kMaxError = 0.05;       // of the weight: what our goal for a mass is

control::TaskSaid task() {
  return {"experiment lift-alone", kHeight_m, kHold_s};
}

/// A light box across before the robot, its middle within reach, nobody at its end.
sim_hal::Scenario light_box(const Trial& t) {
  sim_hal::Draws draws(t.own_seed(19), 19);
  sim_hal::Scenario s = shipped_box();
  s.name = fmt::format("light-box-{}", t.index);
  s.partner = {};
  s.partner.kind = "none";
  s.object.mass = t.index == 0 ? kThesisMass_kg : draws.between(0.3, 1.5);
  s.object.size = {draws.between(0.4, 0.8), draws.between(0.06, 0.15), draws.between(0.15, 0.3)};
  s.object.xyz = {draws.between(0.55, 0.65), draws.between(-0.1, 0.1), 0.0};
  s.object.yaw_deg = draws.between(75.0, 105.0);
  return seen_from(t.view, std::move(s));
}

TrialRows run(const Trial& trial) {
  const std::uint64_t seed = trial.own_seed(20);
  const sim_hal::Scenario scenario = light_box(trial);
  const double weight_n = scenario.object.mass * hal::kGravity_m_s2;
  const auto refused = [&](const std::string& why) {
    return TrialRows{
        {scenario.name, cell(weight_n), "", "0", "0", "", "", "", "", why}, {}, scenario.name + ": " + why};
  };
  auto observation = Observation::make(scenario, trial.method, seed, kHeight_m);
  if (!observation) return refused(observation.error().text());
  const auto& analysis = (*observation)->analysis();
  if (!analysis.scene.target) return refused(analysis.reason);

  // the one nearest to the centre of gravity as it is seen: there it hangs level in one hand
  std::optional<std::size_t> nearest;
  const auto beside = [&](std::size_t i) {
    return (planner::load_point(analysis.candidates[i]) - analysis.scene.target->cog).head<2>().norm();
  };
  for (std::size_t i = 0; i < analysis.candidates.size(); ++i)
    if (analysis.candidates[i].verdict == planner::Verdict::Ok && (!nearest || beside(i) < beside(*nearest)))
      nearest = i;
  if (!nearest) return refused(analysis.reason);

  const control::Config config = config_for(trial.method, task());
  const DirectLift lift = try_grasp(**observation, scenario, analysis.candidates[*nearest], config, seed);
  const bool in_air = lift.lifted && lift.share_robot > kInAir;
  const double measured_n = in_air ? std::abs(lift.measured.force.z()) : NAN;
  TrialRows rows;
  rows.row = {
      scenario.name,       cell(weight_n),     cell(beside(*nearest)), cell(lift.lifted),
      cell(in_air),        cell(lift.robot_n), cell(measured_n),       cell(measured_n / weight_n - 1.0),
      cell(lift.tilt_deg), lift.reason};
  rows.words = in_air
                   ? fmt::format("{}: {:.2f} N measured, {:.2f} N true", scenario.name, measured_n, weight_n)
                   : fmt::format("{}: {}", scenario.name,
                                 lift.reason.empty() ? "not clear of the floor" : lift.reason);
  return rows;
}

std::vector<Figure> figures(const Results& r) {
  int in_air = 0, within = 0, all = 0;
  std::vector<double> errors;
  for (const Row& row : r.trials.rows()) {
    ++all;
    in_air += r.trials.number(row, "in_air") > 0.5;
    const double error = std::abs(r.trials.number(row, "error"));
    if (std::isnan(error)) continue;
    errors.push_back(error);
    within += error <= kMaxError;
  }
  return {
      {"in_air", "lifted clear of the floor by the robot alone", rate(in_air, all), "%", {}, true, "1 of 1"},
      {"error_median", "error of the weight, median", quantile_estimate(errors, 0.5), "%"},
      {"error_p95", "error of the weight, 95 % below", quantile_estimate(errors, 0.95), "%", kMaxError,
       false},
      {"within", "error of the weight within 5 %", rate(within, static_cast<int>(errors.size())), "%"}};
}

picture::Canvas plot(const Results& r) {
  BarPanel panel;
  panel.title = "weight measured by the robot alone, over the true one";
  for (const Row& row : r.trials.rows()) {
    const double error = r.trials.number(row, "error");
    if (!std::isnan(error) && panel.bars.size() < 30)
      panel.bars.push_back({std::to_string(TrialTable::trial_of(row)), 1.0 + error, false});
  }
  panel.levels.push_back({"true", 1.0, picture::kCog});
  return draw_bar_plot({panel});
}

}  // namespace
}  // namespace lift_alone_trials

Experiment lift_alone_experiment() {
  using namespace lift_alone_trials;
  Experiment e;
  e.name = "lift-alone";
  e.title = "Total load by lifting alone";
  e.thesis = "6.3.3";
  e.question =
      "A light box is lifted by the robot alone, at the grasp nearest to its seen centre of gravity; the "
      "vertical force that the arm's torques show at the top is compared with the true weight.";
  e.default_trials = 40;
  e.columns = {"layout",  "weight_n",   "beside_cog_m", "lifted",   "in_air",
               "robot_n", "measured_n", "error",        "tilt_deg", "because"};
  e.run = run;
  e.task = task();
  e.figures = figures;
  e.plot = plot;
  return e;
}

}  // namespace colift::experiments
