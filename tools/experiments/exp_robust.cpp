// Beyond the thesis: a choice that knows what it does not know.

#include <fmt/format.h>

#include <cmath>
#include <numbers>

#include "planner/robust_choice.hpp"
#include "sim_hal/mock/hash_random.hpp"
#include "tools/experiments/bar_plot.hpp"
#include "tools/experiments/experiment.hpp"
#include "tools/experiments/layouts.hpp"
#include "tools/experiments/tried_grasps.hpp"

namespace colift::experiments {
namespace {

constexpr double kSpread_m = 0.04;  // standard deviation of the load that lies on the table somewhere
constexpr double kHeight_m = 0.05, kHold_s = 1.0;
constexpr std::size_t kRoom = 512;
constexpr double kLess_deg = 0.01;  // lower means lower, not equal

TrialRows run(const Trial& trial) {
  const std::uint64_t seed = trial.own_seed(5);
  sim_hal::Scenario scenario = table_layout(trial.index + 2, trial.seed);
  sim_hal::Draws draws(seed, 7500);
  const double r = kSpread_m * std::sqrt(-2.0 * std::log(1.0 - draws.between(0.0, 0.999))),
               a = 2.0 * std::numbers::pi * draws.between(0.0, 1.0);
  scenario.object.cog_offset = {r * std::cos(a), r * std::sin(a), 0.0};
  const auto refused = [&](const std::string& why) {
    Row row{scenario.name, cell(1e3 * r)};
    row.resize(8);
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

  auto robust = planner::RobustChoice::create(config.decision.weights, kRoom);
  if (!robust) return refused(robust.error().text());
  const auto& target = *(*sighting)->look().scene.target;
  planner::UncertainScene scene;
  scene.cog = target.cog;
  scene.cog_covariance = target.cog_covariance;
  scene.cog_covariance.diagonal().head<2>().array() += kSpread_m * kSpread_m;
  scene.partner = (*sighting)->partner()->position;
  scene.partner_covariance = (*sighting)->partner()->covariance;
  using Aim = planner::RobustChoice::Aim;
  const std::size_t nominal = *outcome->decision.chosen;
  const std::size_t choices[] = {nominal,
                                 robust->choose(scene, outcome->candidates, Aim::Expected).value_or(nominal),
                                 robust->choose(scene, outcome->candidates, Aim::Worst).value_or(nominal)};
  double tilt[3] = {NAN, NAN, NAN};
  std::string because;
  for (int k = 0; k < 3; ++k) {
    for (int before = 0; before < k; ++before)
      if (choices[before] == choices[k]) tilt[k] = tilt[before];
    if (!std::isnan(tilt[k])) continue;
    const DirectLift lift = try_grasp(**sighting, scenario, outcome->candidates[choices[k]], config, seed);
    if (lift.lifted) tilt[k] = lift.tilt_deg;
    if (!lift.because.empty()) because = lift.because;
  }
  TrialRows rows;
  rows.row = {scenario.name, cell(1e3 * r)};
  for (int k = 0; k < 3; ++k) {
    rows.row.push_back(cell(outcome->candidates[choices[k]].id));
    rows.row.push_back(cell(tilt[k]));
  }
  rows.row.push_back(because);
  rows.words = fmt::format("{}: tilt nominal {:.2f}, expected {:.2f}, worst {:.2f} deg", scenario.name,
                           tilt[0], tilt[1], tilt[2]);
  return rows;
}

std::vector<Figure> figures(const Results& r) {
  std::vector<Figure> out;
  std::vector<double> tilts[3];
  int differ = 0, n = 0;
  for (const Row& row : r.trials.rows()) {
    const double t[] = {r.trials.number(row, "nominal_tilt_deg"), r.trials.number(row, "expected_tilt_deg"),
                        r.trials.number(row, "worst_tilt_deg")};
    if (std::isnan(t[0]) || std::isnan(t[1]) || std::isnan(t[2])) continue;
    for (int k = 0; k < 3; ++k) tilts[k].push_back(t[k]);
    ++n;
    differ += r.trials.text(row, "nominal_id") != r.trials.text(row, "expected_id");
  }
  const char* names[] = {"nominal", "expected", "worst"};
  std::vector<double> gain;
  for (std::size_t i = 0; i < tilts[0].size(); ++i) gain.push_back(tilts[0][i] - tilts[1][i]);
  for (int k = 0; k < 3; ++k) {
    const std::string name = names[k];
    out.push_back({"tilt_median_" + name, fmt::format("tilt of the {} choice, median", name),
                   quantile_estimate(tilts[k], 0.5), "deg"});
    Figure p95{"tilt_p95_" + name, fmt::format("tilt of the {} choice, 95 % below", name),
               quantile_estimate(tilts[k], 0.95), "deg"};
    if (k > 0 && !tilts[0].empty()) p95.goal = quantile(tilts[0], 0.95) - kLess_deg, p95.at_least = false;
    out.push_back(std::move(p95));
  }
  out.push_back({"tilt_saved_mean", "tilt saved by the expected choice, mean", mean_estimate(gain), "deg",
                 kLess_deg, true});
  out.push_back({"choices_differ", "layouts in which both choose differently", rate(differ, n), "%"});
  return out;
}

picture::Canvas plot(const Results& r) {
  BarPanel p50{"Tilt, median (deg)", {}, {}, {}}, p95{"Tilt, 95 % below (deg)", {}, {}, {}};
  for (const Figure& f : figures(r)) {
    const bool median = f.key.starts_with("tilt_median_");
    if (!median && !f.key.starts_with("tilt_p95_")) continue;
    (median ? p50 : p95)
        .bars.push_back(
            {f.key.substr(f.key.rfind('_') + 1), f.estimate.value, false, f.estimate.low, f.estimate.high});
  }
  return draw_bar_plot({p50, p95});
}

}  // namespace

Experiment robust_experiment() {
  Experiment e;
  e.name = "robust";
  e.title = "Choice over an uncertain centre of gravity";
  e.thesis = "beyond it";
  e.question =
      "A table whose centre of gravity lies off its shape's by a normal deviate of 4 cm in either direction, "
      "as with "
      "something on it. Lifted with the nominal choice and with those that minimise the expected and the "
      "worst "
      "cost over 10 000 what-ifs.";
  e.default_trials = 100;
  e.columns = {"layout",           "cog_off_mm",     "nominal_id",
               "nominal_tilt_deg", "expected_id",    "expected_tilt_deg",
               "worst_id",         "worst_tilt_deg", "because"};
  e.run = run;
  e.figures = figures;
  e.plot = plot;
  return e;
}

}  // namespace colift::experiments
