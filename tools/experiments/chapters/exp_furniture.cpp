// Beyond the thesis: what people carry in pairs that is neither table, box, pipe nor chair.

#include <fmt/format.h>

#include <algorithm>

#include "tools/experiments/bar_plot.hpp"
#include "tools/experiments/experiment.hpp"
#include "tools/experiments/runs/whole_lift.hpp"
#include "tools/experiments/trials/furniture.hpp"
#include "tools/experiments/trials/layouts.hpp"
#include "tools/experiments/trials/tried_grasps.hpp"

namespace colift::experiments {
namespace furniture_trials {
namespace {

constexpr int kEnough = 5;  // candidates from which a partner's grasp leaves a choice

int in_reach(const control::RunRecord& record) {
  if (!record.decision) return 0;
  const auto& all = record.decision->candidates;
  return static_cast<int>(std::count_if(all.begin(), all.end(), is_in_reach));
}

TrialRows run(const Trial& trial) {
  const auto& kinds = furniture_kinds();
  const std::string& kind = kinds[static_cast<std::size_t>(trial.index) % kinds.size()];
  const sim_hal::Scenario scenario = seen_from(trial.view, furniture_layout(trial.index, trial.seed));
  const std::uint64_t seed = trial.own_seed(61);
  const auto lift = run_whole_lift(scenario, trial.method, seed);
  if (!lift) {
    Row row{kind, scenario.name, cell(scenario.object.mass), "0", "error"};
    row.resize(10);
    row.push_back(lift.error().text());
    return {row, {}, lift.error().text()};
  }
  const control::RunRecord& record = lift->record;
  std::string grasp;
  if (record.decision && record.decision->decision.chosen)
    grasp = planner::name_of(record.decision->candidates[*record.decision->decision.chosen].kind);
  const int reached = in_reach(record);
  TrialRows rows;
  rows.row = {kind,
              scenario.name,
              cell(scenario.object.mass),
              cell(reached),
              word(record.outcome),
              grasp,
              cell(lift->tilt_deg),
              cell(lift->share_robot),
              cell(1e3 * lift->slip_m),
              cell(lift->hit_something),
              record.reason};
  rows.words =
      fmt::format("{}: {} in reach, {}: {}", scenario.name, reached, word(record.outcome), record.reason);
  if (reached < kEnough || record.outcome != control::RunRecord::Result::Lifted)
    rows.kept = KeptLift{scenario, seed};
  return rows;
}

std::vector<Figure> figures(const Results& r) {
  std::vector<Figure> out;
  int all = 0, all_enough = 0, all_lifted = 0, hit = 0;
  for (const std::string& kind : furniture_kinds()) {
    int n = 0, enough = 0, lifted = 0;
    for (const Row& row : r.trials.rows()) {
      if (r.trials.text(row, "kind") != kind) continue;
      ++n;
      enough += r.trials.number(row, "in_reach") >= kEnough;
      lifted += r.trials.text(row, "outcome") == "lifted";
      hit += r.trials.number(row, "hit") > 0.5;
    }
    out.push_back({"reach_" + kind, kind + ": five or more candidates in reach", rate(enough, n), "%", 0.9});
    out.push_back({"lifted_" + kind, kind + ": lifted, held, lowered, released", rate(lifted, n), "%", 0.9});
    all += n, all_enough += enough, all_lifted += lifted;
  }
  out.push_back({"reach", "all: five or more candidates in reach", rate(all_enough, all), "%", 0.9});
  out.push_back({"lifted", "all: lifted, held, lowered, released", rate(all_lifted, all), "%", 0.9});
  out.push_back({"hit", "all: runs in which the robot met something", rate(hit, all), "%", 0.0, false});
  return out;
}

picture::Canvas plot(const Results& r) {
  BarPanel reach{"Five candidates in reach (%)", {}, {}, 100.0},
      lifted{"Lifted, held, lowered, released (%)", {}, {}, 100.0};
  for (const Figure& f : figures(r)) {
    const bool is_lift = f.key.starts_with("lifted_");
    if (!is_lift && !f.key.starts_with("reach_")) continue;
    (is_lift ? lifted : reach)
        .bars.push_back({f.key.substr(f.key.find('_') + 1), 100.0 * f.estimate.value, false,
                         100.0 * f.estimate.low, 100.0 * f.estimate.high});
  }
  return draw_bar_plot({reach, lifted});
}

}  // namespace
}  // namespace furniture_trials

Experiment furniture_experiment() {
  using namespace furniture_trials;
  Experiment e;
  e.name = "furniture";
  e.title = "Other things that two people carry";
  e.thesis = "beyond";
  e.question =
      "The whole job with a stool, shelf, ladder, crate, suitcase, box with a lid, bench and a frame of "
      "tubes, "
      "each drawn at random, in turn. A candidate is in reach when hand and arm can carry it out.";
  e.default_trials = 400;
  e.columns = {"kind",     "layout",      "mass_kg", "in_reach", "outcome", "grasp",
               "tilt_deg", "share_robot", "slip_mm", "hit",      "because"};
  e.run = run;
  e.figures = figures;
  e.plot = plot;
  return e;
}

}  // namespace colift::experiments
