// Beyond the thesis: what a lift of a few millimetres tells.

#include <fmt/format.h>

#include <cmath>
#include <numbers>

#include "control/test_lift.hpp"
#include "sim_hal/mock/hash_random.hpp"
#include "tools/experiments/bar_plot.hpp"
#include "tools/experiments/experiment.hpp"
#include "tools/experiments/layouts.hpp"
#include "tools/experiments/tried_grasps.hpp"
#include "tools/picture/palette.hpp"

namespace colift::experiments {
namespace {

constexpr double kLeast_m = 0.10, kMost_m = 0.20;
constexpr double kHeight_m = 0.05, kHold_s = 1.0, kBudget_deg = 2.0;

const char* word(control::TestLift::Next next) {
  using Next = control::TestLift::Next;
  return next == Next::GoOn ? "go on" : next == Next::OtherShare ? "other share" : "re-grasp";
}

hal::Vec3 grasp_point(const planner::GraspCandidate& c) {
  return c.position + c.depth_m * c.approach;
}

TrialRows run(const Trial& trial) {
  const std::uint64_t seed = trial.own_seed(6);
  sim_hal::Scenario scenario = table_layout(trial.index + 2, trial.seed);
  sim_hal::Draws draws(seed, 7600);
  const double off = draws.between(kLeast_m, kMost_m), a = 2.0 * std::numbers::pi * draws.between(0.0, 1.0);
  scenario.object.cog_offset = {off * std::cos(a), off * std::sin(a), 0.0};
  const auto refused = [&](const std::string& why) {
    Row row{scenario.name, cell(scenario.object.mass), cell(1e3 * off)};
    row.resize(11);
    row.push_back(why);
    return TrialRows{row, {}, scenario.name + ": " + why};
  };
  auto sighting = Sighting::make(scenario, trial.method, seed, kHeight_m);
  if (!sighting) return refused(sighting.error().text());
  control::Config config = config_for(trial.method);
  config.task.lift_height_m = kHeight_m;
  config.task.hold_s = kHold_s;
  const auto outcome = (*sighting)->decide(config);
  if (!outcome) return refused(outcome.error().text());
  if (!outcome->decision.chosen) return refused(outcome->decision.because);
  const planner::GraspCandidate& first = outcome->candidates[*outcome->decision.chosen];
  const DirectLift blind = try_grasp(**sighting, scenario, first, config, seed);

  const control::TestLiftConfig test_config;
  control::Config small = config;
  small.task.lift_height_m = test_config.height_m;
  small.task.lift_s = 1.0;
  small.task.hold_s = test_config.hold_s;
  const DirectLift test = try_grasp(**sighting, scenario, first, small, seed);
  if (!test.held) return refused("test lift: " + test.because);
  control::TestLiftInput input;
  input.felt = test.felt;
  input.palm = test.palm_W;
  input.grasp = grasp_point(first);
  input.partner = (*sighting)->partner()->position;
  input.cog = (*sighting)->look().scene.target->cog;
  input.cog_covariance = (*sighting)->look().scene.target->cog_covariance;
  input.share_predicted = outcome->decision.share;
  const auto known = understand_test_lift(input, test_config);
  if (!known) return refused(known.error().text());

  DirectLift lift = blind;
  std::string because = known->because;
  if (known->next == control::TestLift::Next::Regrasp) {
    // put down where it stood, so the scene is as it was
    const auto again = (*sighting)->decide(config, known->cog);
    if (again && again->decision.chosen)
      lift = try_grasp(**sighting, scenario, again->candidates[*again->decision.chosen], config, seed);
    else
      lift.lifted = false, lift.tilt_deg = NAN, because += "; no grasp fits it";
  }
  const double cog_error = (known->cog - (*sighting)->true_cog()).head<2>().norm();
  TrialRows rows;
  rows.row = {scenario.name,
              cell(scenario.object.mass),
              cell(1e3 * off),
              cell(blind.lifted ? blind.tilt_deg : NAN),
              word(known->next),
              cell(known->mass_kg),
              cell(1e3 * cog_error),
              cell(1e3 * known->lever_m),
              cell(known->share),
              cell(blind.share_robot),
              cell(lift.lifted ? lift.tilt_deg : NAN),
              because};
  rows.words = fmt::format("{}: {:.0f} mm off: tilt {:.2f} deg; {}: {:.2f} deg", scenario.name, 1e3 * off,
                           blind.tilt_deg, word(known->next), lift.tilt_deg);
  return rows;
}

std::vector<Figure> figures(const Results& r) {
  std::vector<double> before, after, mass, cog;
  int n = 0, broke = 0, recovered = 0, spoilt = 0;
  for (const Row& row : r.trials.rows()) {
    if (r.trials.text(row, "next").empty()) continue;
    ++n;
    const double b = r.trials.number(row, "tilt_before_deg"), t = r.trials.number(row, "tilt_after_deg");
    const bool bad = !(b <= kBudget_deg), good = t <= kBudget_deg;
    broke += bad;
    recovered += bad && good;
    spoilt += !bad && !good;
    before.push_back(b);
    after.push_back(t);
    const double m = r.trials.number(row, "mass_kg");
    mass.push_back(std::abs(r.trials.number(row, "mass_measured_kg") - m) / m);
    cog.push_back(r.trials.number(row, "cog_error_mm"));
  }
  return {
      {"broke_budget", "lifts that would tilt by more than 2 deg", rate(broke, n), "%"},
      {"recovered", "... of them below 2 deg after the test lift", rate(recovered, broke), "%", 0.90, true},
      {"spoilt", "lifts that only the test lift made worse than 2 deg", rate(spoilt, n - broke), "%"},
      {"tilt_p95_before", "tilt without a test lift, 95 % below", quantile_estimate(before, 0.95), "deg"},
      {"tilt_p95_after", "tilt with it, 95 % below", quantile_estimate(after, 0.95), "deg"},
      {"mass_error_median", "relative error of the mass, median", quantile_estimate(mass, 0.5), "%"},
      {"cog_error_median", "error of the corrected centre of gravity, median", quantile_estimate(cog, 0.5),
       "mm"}};
}

picture::Canvas plot(const Results& r) {
  std::vector<BarPanel> panels;
  for (const char* column : {"tilt_before_deg", "tilt_after_deg"}) {
    BarPanel panel{fmt::format("{} a test lift: tilt (deg)",
                               std::string(column) == "tilt_before_deg" ? "Without" : "With"),
                   {},
                   {{"budget", kBudget_deg, picture::kCog}},
                   8.0};
    for (const Row& row : r.trials.rows()) {
      if (panel.bars.size() == 16) break;
      panel.bars.push_back({letter(panel.bars.size()), r.trials.number(row, column), false});
    }
    panels.push_back(std::move(panel));
  }
  return draw_bar_plot(panels);
}

}  // namespace

Experiment wrong_cog_experiment() {
  Experiment e;
  e.name = "wrong-cog";
  e.title = "Uneven density and a test lift";
  e.thesis = "beyond it";
  e.question =
      "A table whose centre of gravity lies 10 to 20 cm off its shape's, in any direction. Lifted at once, "
      "and after a "
      "test lift of 6 mm that measures it from the arm's external torques and may put the table down for "
      "another grasp.";
  e.default_trials = 100;
  e.columns = {"layout",         "mass_kg",          "cog_off_mm",     "tilt_before_deg",
               "next",           "mass_measured_kg", "cog_error_mm",   "lever_mm",
               "share_measured", "share_robot",      "tilt_after_deg", "because"};
  e.run = run;
  e.figures = figures;
  e.plot = plot;
  return e;
}

}  // namespace colift::experiments
