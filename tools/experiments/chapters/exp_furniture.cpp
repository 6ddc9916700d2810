// Beyond the thesis: what people carry in pairs that is neither table, box, pipe nor chair.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "tools/experiments/bar_plot.hpp"
#include "tools/experiments/experiment.hpp"
#include "tools/experiments/runs/whole_lift.hpp"
#include "tools/experiments/trials/furniture.hpp"
#include "tools/experiments/trials/layouts.hpp"
#include "tools/experiments/trials/tried_grasps.hpp"

namespace colift::experiments {
namespace furniture_trials {
namespace {

constexpr double kCog_mm = 20.0;
constexpr int kEnough = 5;  // candidates from which a partner's grasp leaves a choice

int in_reach(const control::RunRecord& record) {
  if (!record.decision) return 0;
  const auto& all = record.decision->candidates;
  return static_cast<int>(std::count_if(all.begin(), all.end(), is_in_reach));
}

/// How far from the truth the centre of gravity is seen before anything moves (m): level, and upwards.
struct CogError {
  double level_m = NAN, up_m = NAN;
};

CogError cog_error(const control::RunRecord& record, const hal::Vec3& truth) {
  if (!record.analysis || !record.analysis->scene.target) return {};
  const hal::Vec3 e = record.analysis->scene.target->cog - truth;
  return {e.head<2>().norm(), e.z()};
}

TrialRows run(const Trial& trial) {
  const auto& kinds = furniture_kinds();
  const std::string& kind = kinds[static_cast<std::size_t>(trial.index) % kinds.size()];
  const sim_hal::Scenario scenario = seen_from(trial.view, furniture_layout(trial.index, trial.seed));
  const std::uint64_t seed = trial.own_seed(61);
  hal::Vec3 true_cog = hal::Vec3::Zero();
  LiftHooks hooks;
  hooks.started = [&](const sim_hal::SimWorld& world) { true_cog = world.truth().cog_W; };
  const auto lift = run_whole_lift(scenario, trial.method, seed, hooks);
  if (!lift) {
    Row row{kind, scenario.name, cell(scenario.object.mass), "0", "error"};
    row.resize(12);
    row.push_back(lift.error().text());
    return {row, {}, lift.error().text()};
  }
  const control::RunRecord& record = lift->record;
  std::string grasp;
  if (record.decision && record.decision->decision.chosen)
    grasp = planner::name_of(record.decision->candidates[*record.decision->decision.chosen].kind);
  const int reached = in_reach(record);
  const CogError cog = cog_error(record, true_cog);
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
              cell(1e3 * cog.level_m),
              cell(1e3 * cog.up_m),
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
  std::vector<double> cog_mm;
  for (const Row& row : r.trials.rows())
    if (const double mm = r.trials.number(row, "cog_mm"); std::isfinite(mm)) cog_mm.push_back(mm);
  const auto near = std::count_if(cog_mm.begin(), cog_mm.end(), [](double mm) { return mm <= kCog_mm; });
  out.push_back({"cog", "all: centre of gravity seen within 20 mm, level",
                 rate(static_cast<int>(near), static_cast<int>(cog_mm.size())), "%", 0.9});
  out.push_back({"hit", "all: runs in which the robot met something", rate(hit, all), "%", 0.0, false});
  return out;
}

picture::Canvas plot(const Results& r) {
  BarPanel reach{"Five candidates in reach (%)", {}, {}, 100.0},
      lifted{"Lifted, held, lowered, released (%)", {}, {}, 100.0};
  for (const Figure& f : figures(r)) {
    const bool is_lift = f.key.starts_with("lifted_");
    if (!is_lift && !f.key.starts_with("reach_")) continue;
    (is_lift ? lifted : reach).bars.push_back(percent_bar(f.key.substr(f.key.find('_') + 1), f.estimate));
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
      "tubes, each drawn at random, in turn. A candidate is in reach when hand and arm can carry it out.";
  e.default_trials = 400;
  e.columns = {"kind",        "layout",  "mass_kg", "in_reach", "outcome",   "grasp",  "tilt_deg",
               "share_robot", "slip_mm", "hit",     "cog_mm",   "cog_up_mm", "because"};
  e.run = run;
  e.figures = figures;
  e.plot = plot;
  return e;
}

}  // namespace colift::experiments
