// Beyond the thesis: what is left of a lift when the sensors have the faults of real ones?

#include <fmt/format.h>

#include <array>
#include <cmath>

#include "sim_hal/imperfect/rig_errors.hpp"
#include "tools/experiments/bar_plot.hpp"
#include "tools/experiments/experiment.hpp"
#include "tools/experiments/runs/whole_lift.hpp"
#include "tools/experiments/trials/layouts.hpp"

namespace colift::experiments {
namespace imperfect_trials {
namespace {

constexpr int kDrawn = 8;  // trials before it have shipped scenes
constexpr double kHeight_m = 0.05, kHold_s = 1.0;
constexpr std::array<const char*, 2> kRigs{"ideal", "imperfect"};

/// Row of one lift: outcome, tilt, share error, mass error, breaches, why.
void add_lift(TrialRows& rows, const hal::Result<WholeLift>& lift, double true_mass_kg, const char* rig) {
  Row& row = rows.row;
  if (!lift) {
    const std::string why = lift.error().text();
    row.insert(row.end(), {"error", cell(NAN), cell(NAN), cell(NAN), cell(0), why});
    rows.words += fmt::format("; {}: error: {}", rig, why);
    return;
  }
  const control::RunRecord& r = lift->record;
  const bool lifted = r.outcome == control::RunRecord::Result::Lifted && r.lift;
  row.push_back(word(r.outcome));
  row.push_back(cell(lifted ? lift->tilt_deg : NAN));
  row.push_back(cell(lifted ? std::abs(r.lift->share_robot - lift->share_robot) : NAN));
  row.push_back(cell(lifted ? std::abs(r.lift->mass_kg / true_mass_kg - 1.0) : NAN));
  row.push_back(cell(static_cast<int>(lift->verdict.breaches.size())));
  row.push_back(lift->verdict.breaches.empty() ? r.reason : lift->verdict.breaches.front());
  rows.words += fmt::format("; {}: {}, {} breaches", rig, word(r.outcome), lift->verdict.breaches.size());
}

TrialRows run(const Trial& trial) {
  sim_hal::Scenario scenario = mixed_layout(trial.index + kDrawn, trial.seed);
  scenario.task.height = kHeight_m;
  scenario.task.hold_s = kHold_s;
  scenario = seen_from(trial.view, scenario);
  const auto figures = sim_hal::load_rig_figures("imperfect");
  TrialRows rows;
  rows.row = {scenario.name, cell(scenario.object.mass)};
  rows.words = scenario.name;
  if (!figures) {  // the file is compiled in and tested
    rows.row.resize(2 + 2 * 6 + 1);
    return rows;
  }
  const std::uint64_t seed = trial.own_seed(14);
  const sim_hal::RigErrors errors = sim_hal::draw_rig_errors(*figures, seed);
  rows.row.push_back(cell(errors.friction));
  add_lift(rows, run_whole_lift(scenario, trial.method, seed), scenario.object.mass, kRigs[0]);
  LiftHooks hooks;
  hooks.errors = errors;
  const auto lift = run_whole_lift(sim_hal::with_errors(scenario, errors), trial.method, seed, hooks);
  add_lift(rows, lift, scenario.object.mass, kRigs[1]);
  if (!lift || lift->record.outcome != control::RunRecord::Result::Lifted)
    rows.kept = KeptLift{scenario, seed, kRigs[1]};
  return rows;
}

std::vector<double> numbers(const Results& r, const std::string& column) {
  std::vector<double> out;
  for (const Row& row : r.trials.rows())
    if (const double v = r.trials.number(row, column); !std::isnan(v)) out.push_back(v);
  return out;
}

std::vector<Figure> figures(const Results& r) {
  std::vector<Figure> out;
  for (const std::string rig : kRigs) {
    int all = 0, lifted = 0, breached = 0;
    for (const Row& row : r.trials.rows()) {
      ++all;
      lifted += r.trials.text(row, rig + "_outcome") == "lifted";
      breached += r.trials.number(row, rig + "_breaches") > 0;
    }
    const auto worst_of = [&](const char* column, double p) {
      return quantile_estimate(numbers(r, rig + column), p);
    };
    out.push_back({rig + "_lifted", rig + ": jobs that lifted", rate(lifted, all), "%"});
    out.push_back(
        {rig + "_breached", rig + ": jobs in which the judge found a breach", rate(breached, all), "%"});
    out.push_back({rig + "_tilt", rig + ": tilt, median", worst_of("_tilt_deg", 0.5), "deg"});
    out.push_back({rig + "_tilt_95", rig + ": tilt, 95 % quantile", worst_of("_tilt_deg", 0.95), "deg"});
    out.push_back(
        {rig + "_share", rig + ": error of the measured share, median", worst_of("_share_error", 0.5), ""});
    out.push_back(
        {rig + "_mass", rig + ": relative error of the mass, median", worst_of("_mass_error", 0.5), "%"});
  }
  return out;
}

picture::Canvas plot(const Results& r) {
  std::vector<BarPanel> panels;
  BarPanel panel;
  panel.title = "jobs that lifted (%)";
  panel.y_high = 100.0;
  for (const Figure& f : figures(r))
    if (f.key.ends_with("_lifted"))
      panel.bars.push_back({f.key.substr(0, f.key.find('_')), 100 * f.estimate.value, false,
                            100 * f.estimate.low, 100 * f.estimate.high});
  panels.push_back(std::move(panel));
  return draw_bar_plot(panels);
}

}  // namespace
}  // namespace imperfect_trials

Experiment imperfect_experiment() {
  using namespace imperfect_trials;
  Experiment e;
  e.name = "imperfect";
  e.title = "A rig with the faults of real sensors";
  e.thesis = "beyond it";
  e.question =
      "The same whole jobs on tables, boxes, pipes and chairs of random size and pose, once with ideal "
      "sensors and once with those of config/rig/imperfect.yaml, drawn anew for each trial: what is lifted, "
      "how level, and how far off are share and mass?";
  e.default_trials = 20;
  e.columns = {"layout", "mass_kg", "friction"};
  for (const std::string rig : kRigs)
    for (const char* column :
         {"_outcome", "_tilt_deg", "_share_error", "_mass_error", "_breaches", "_because"})
      e.columns.push_back(rig + column);
  e.run = run;
  e.task = control::TaskSaid{"experiment imperfect", kHeight_m, kHold_s};
  e.figures = figures;
  e.plot = plot;
  return e;
}

}  // namespace colift::experiments
