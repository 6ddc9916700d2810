// Thesis 6.3.4: objects that are not made of planes.

#include <fmt/format.h>

#include <array>
#include <cmath>

#include "tools/experiments/bar_plot.hpp"
#include "tools/experiments/experiment.hpp"
#include "tools/experiments/runs/whole_lift.hpp"
#include "tools/experiments/trials/layouts.hpp"

namespace colift::experiments {
namespace complex_trials {
namespace {

constexpr std::array<const char*, 2> kObjects{"pipe", "chair"};

const char* word(control::RunRecord::Result outcome) {
  using Result = control::RunRecord::Result;
  return outcome == Result::Lifted ? "lifted" : outcome == Result::Aborted ? "aborted" : "refused";
}

TrialRows run(const Trial& trial) {
  const bool pipe = trial.index % 2 == 0;
  const char* object = kObjects[pipe ? 0 : 1];
  const sim_hal::Scenario scenario = seen_from(trial.view, pipe ? pipe_layout(trial.index / 2, trial.seed)
                                                                : chair_layout(trial.index / 2, trial.seed));
  const auto lift = run_whole_lift(scenario, trial.method, trial.own_seed(4));
  if (!lift) {
    Row row{object, scenario.name, cell(scenario.object.mass), "error"};
    row.resize(9);
    row.push_back(lift.error().text());
    return {row, {}, lift.error().text()};
  }
  const control::RunRecord& record = lift->record;
  std::string kind;
  if (record.decision && record.decision->decision.chosen)
    kind = planner::name_of(record.decision->candidates[*record.decision->decision.chosen].kind);
  return {
      {object, scenario.name, cell(scenario.object.mass), word(record.outcome), kind, cell(lift->tilt_deg),
       cell(lift->share_robot), cell(1e3 * lift->slip_m), cell(lift->hit_something), record.reason},
      {},
      fmt::format("{}: {}: {}", scenario.name, word(record.outcome), record.reason)};
}

std::vector<Figure> figures(const Results& r) {
  std::vector<Figure> out;
  for (const char* object : kObjects) {
    int n = 0, lifted = 0, hit = 0;
    std::vector<double> tilt, slip;
    for (const Row& row : r.trials.rows()) {
      if (r.trials.text(row, "object") != object) continue;
      ++n;
      hit += r.trials.number(row, "hit") > 0.5;
      if (r.trials.text(row, "outcome") != "lifted") continue;
      ++lifted;
      tilt.push_back(r.trials.number(row, "tilt_deg"));
      slip.push_back(r.trials.number(row, "slip_mm"));
    }
    const std::string o = object;
    out.push_back({"lifted_" + o, o + ": lifted, held, lowered, released", rate(lifted, n), "%", 0.95, true,
                   o == "pipe" ? "slipped" : "2 of 2 poses shown"});
    out.push_back(
        {"slip_p95_" + o, o + ": slip in the hand, 95 % below", quantile_estimate(slip, 0.95), "mm"});
    out.push_back({"tilt_median_" + o, o + ": tilt, median", quantile_estimate(tilt, 0.5), "deg"});
    out.push_back({"tilt_p95_" + o, o + ": tilt, 95 % below", quantile_estimate(tilt, 0.95), "deg"});
    out.push_back({"hit_" + o, o + ": runs in which the robot met something", rate(hit, n), "%", 0.0, false});
  }
  return out;
}

picture::Canvas plot(const Results& r) {
  BarPanel lifted{"Lifted, held, lowered, released (%)", {}, {}, 100.0},
      slip{"Slip in the hand, 95 % below (mm)", {}, {}, {}};
  for (const Figure& f : figures(r)) {
    const bool rate_of = f.key.starts_with("lifted_");
    if (!rate_of && !f.key.starts_with("slip_p95_")) continue;
    const double scale = rate_of ? 100.0 : 1.0;
    Bar bar{f.key.substr(f.key.rfind('_') + 1), scale * f.estimate.value, false, scale * f.estimate.low,
            scale * f.estimate.high};
    (rate_of ? lifted : slip).bars.push_back(std::move(bar));
  }
  return draw_bar_plot({lifted, slip});
}

}  // namespace
}  // namespace complex_trials

Experiment complex_experiment() {
  using namespace complex_trials;
  Experiment e;
  e.name = "complex";
  e.title = "Objects of complex shape";
  e.thesis = "6.3.4, figures 6.13 and 6.14";
  e.question =
      "The whole job, from the first look to the retreat, with a pipe on two blocks (even trials) and a "
      "chair (odd trials) and a partner at the far side.";
  e.default_trials = 400;
  e.columns = {"object",   "layout",      "mass_kg", "outcome", "grasp",
               "tilt_deg", "share_robot", "slip_mm", "hit",     "because"};
  e.run = run;
  e.figures = figures;
  e.plot = plot;
  return e;
}

}  // namespace colift::experiments
