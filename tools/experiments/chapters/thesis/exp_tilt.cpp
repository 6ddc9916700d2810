// Thesis 6.3.2: is the chosen grasp the one that tilts the object least?

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "tools/experiments/bar_plot.hpp"
#include "tools/experiments/experiment.hpp"
#include "tools/experiments/trials/layouts.hpp"
#include "tools/experiments/trials/tried_grasps.hpp"
#include "tools/visualization/palette.hpp"

namespace colift::experiments {
namespace tilt_trials {
namespace {

constexpr std::size_t kGrasps = 8;  // thesis: 7 and 8
constexpr std::size_t kRivals = 2;  // of them the cheapest that were not chosen
constexpr double kTie_deg = 0.3;    // closer than a tremor of the partner is no difference
constexpr double kTilt_deg = 2.0, kMedian_deg = 1.0;
constexpr double kHeight_m = 0.05, kHold_s = 1.0;

control::TaskSaid task() {
  return {"experiment tilt", kHeight_m, kHold_s};
}

std::vector<bool> possible(const control::Outcome& outcome, const control::SceneAnalysis& analysis) {
  // what the arm reaches without a collision, whatever the decision thinks of its load
  std::vector<bool> out(outcome.candidates.size());
  for (std::size_t i = 0; i < out.size(); ++i) {
    using planner::Verdict;
    const Verdict v =
        i < analysis.candidates.size() ? analysis.candidates[i].verdict : outcome.candidates[i].verdict;
    const Verdict now = outcome.candidates[i].verdict;
    out[i] = (v == Verdict::Ok || v == Verdict::Chosen) && now != Verdict::NearPartner;
  }
  return out;
}

TrialRows refused(const std::string& name, double mass, const std::string& why) {
  Row row{name, cell(mass)};
  row.resize(14);
  row.push_back(why);
  return {row, {}, name + ": " + why};
}

TrialRows run(const Trial& trial) {
  const std::uint64_t seed = trial.own_seed(1);
  const sim_hal::Scenario scenario = seen_from(trial.view, table_layout(trial.index, trial.seed));
  auto observation = Observation::make(scenario, trial.method, seed, kHeight_m);
  if (!observation) return refused(scenario.name, scenario.object.mass, observation.error().text());
  control::Config config = config_for(trial.method, task());
  const auto outcome = (*observation)->decide(config);
  if (!outcome) return refused(scenario.name, scenario.object.mass, outcome.error().text());
  if (!outcome->decision.chosen)
    return refused(scenario.name, scenario.object.mass, outcome->decision.reason);

  const std::size_t chosen = *outcome->decision.chosen;
  std::vector<std::size_t> always{chosen};
  for (const std::size_t i : next_best(*outcome, kRivals)) always.push_back(i);
  const auto tried =
      spread_over(outcome->candidates, possible(*outcome, (*observation)->analysis()), always, kGrasps);

  TrialRows rows;
  double chosen_tilt = NAN, best_tilt = NAN, share = NAN;
  std::size_t best = chosen, lifted = 0;
  std::string reason;
  for (std::size_t k = 0; k < tried.size(); ++k) {
    const std::size_t i = tried[k];
    const planner::GraspCandidate& c = outcome->candidates[i];
    const DirectLift lift = try_grasp(**observation, scenario, c, config, seed);
    const auto& score = outcome->decision.scores[i];
    if (lift.lifted) {
      ++lifted;
      if (!(lift.tilt_deg >= best_tilt)) best = i, best_tilt = lift.tilt_deg;
    }
    if (i == chosen) {
      chosen_tilt = lift.lifted ? lift.tilt_deg : NAN;
      share = lift.share_robot;
      reason = lift.reason;
    }
    rows.details.push_back({letter(k), cell(c.id), cell(i == chosen), cell(c.position.x()),
                            cell(c.position.y()), cell(c.position.z()), cell(score ? score->cost : NAN),
                            cell(score ? score->share : NAN), cell(c.stability.value_or(NAN)),
                            cell(lift.lifted), cell(lift.tilt_deg), cell(lift.share_robot),
                            cell(1e3 * lift.slip_m), cell(lift.hit_something), lift.reason});
  }
  const control::SceneAnalysis& analysis = (*observation)->analysis();
  const double partner_off = ((*observation)->partner()->position - (*observation)->true_partner()).norm();
  const double cog_off = (analysis.scene.target->cog - (*observation)->true_cog()).head<2>().norm();
  const double excess = chosen_tilt - best_tilt;
  rows.row = {scenario.name,
              cell(scenario.object.mass),
              cell(static_cast<int>(tried.size())),
              cell(static_cast<int>(lifted)),
              cell(outcome->candidates[chosen].id),
              cell(!std::isnan(chosen_tilt)),
              cell(chosen_tilt),
              cell(outcome->candidates[best].id),
              cell(best_tilt),
              cell(best == chosen),
              cell(excess),
              cell(share),
              cell(1e3 * partner_off),
              cell(1e3 * cog_off),
              reason};
  rows.words = std::isnan(chosen_tilt)
                   ? fmt::format("{}: the chosen grasp was not lifted: {}", scenario.name, reason)
                   : fmt::format("{}: tilt {:.2f} deg, the minimum of {} grasps {:.2f} deg", scenario.name,
                                 chosen_tilt, tried.size(), best_tilt);
  return rows;
}

std::vector<Figure> figures(const Results& r) {
  int decided = 0, lifted = 0, best = 0, near = 0;
  std::vector<double> tilt, others;
  for (const Row& row : r.trials.rows()) {
    if (r.trials.text(row, "chosen_id").empty()) continue;
    ++decided;
    const double mine = r.trials.number(row, "chosen_tilt_deg"), excess = r.trials.number(row, "excess_deg");
    if (std::isnan(mine)) continue;
    ++lifted;
    tilt.push_back(mine);
    best += excess <= 0.0;
    near += excess <= kTie_deg;
  }
  for (const Row& row : r.details.rows())
    if (r.details.number(row, "lifted") > 0.5 && r.details.number(row, "chosen") < 0.5)
      others.push_back(r.details.number(row, "tilt_deg"));
  const int all = static_cast<int>(r.trials.rows().size());
  return {{"decided", "layouts in which a grasp was chosen", rate(decided, all), "%"},
          {"lifted", "chosen grasps that lifted the table", rate(lifted, decided), "%"},
          {"chosen_is_best",
           "chosen grasp tilts least of those tried",
           rate(best, decided),
           "%",
           {},
           true,
           "2 of 2 poses"},
          {"chosen_best_or_within_0.3deg", "chosen is best or within 0.3 deg of it", rate(near, decided), "%",
           0.95, true, "2 of 2 poses"},
          {"tilt_median_deg", "tilt of the chosen grasp, median", quantile_estimate(tilt, 0.5), "deg",
           kMedian_deg, false},
          {"tilt_p95_deg", "tilt of the chosen grasp, 95 % below", quantile_estimate(tilt, 0.95), "deg",
           kTilt_deg, false},
          {"other_tilt_median_deg", "tilt of the other grasps tried, median", quantile_estimate(others, 0.5),
           "deg"},
          {"other_tilt_p95_deg", "tilt of the other grasps tried, 95 % below",
           quantile_estimate(others, 0.95), "deg"}};
}

picture::Canvas plot(const Results& r) {
  std::vector<BarPanel> panels;
  for (const Row& row : r.trials.rows()) {
    if (panels.size() == 4) break;
    const int trial = TrialTable::trial_of(row);
    BarPanel panel;
    panel.title = fmt::format("{}: tilt after the lift (deg)", r.trials.text(row, "layout"));
    for (const Row& d : r.details.rows()) {
      if (TrialTable::trial_of(d) != trial) continue;
      const bool lifted = r.details.number(d, "lifted") > 0.5;
      panel.bars.push_back({r.details.text(d, "grasp"), lifted ? r.details.number(d, "tilt_deg") : NAN,
                            r.details.number(d, "chosen") > 0.5});
    }
    if (panel.bars.empty()) continue;
    // as they lie on the object: the letters say nothing about the order
    panels.push_back(std::move(panel));
  }
  return draw_bar_plot(panels);
}

}  // namespace
}  // namespace tilt_trials

Experiment tilt_experiment() {
  using namespace tilt_trials;
  Experiment e;
  e.name = "tilt";
  e.title = "Collaborative grasp stability";
  e.thesis = "6.3.2, figures 6.6 and 6.9";
  e.question =
      "A table and a partner at its far side. Up to eight grasps that the arm reaches, the chosen one and "
      "its two "
      "nearest rivals among them, are carried out, each in a world of its own: how far does the table tilt "
      "after a lift of 5 cm?";
  e.default_trials = 200;
  e.columns = {"layout",           "mass_kg",        "tried",           "lifted",
               "chosen_id",        "chosen_lifted",  "chosen_tilt_deg", "best_id",
               "best_tilt_deg",    "chosen_is_best", "excess_deg",      "share_robot",
               "partner_error_mm", "cog_error_mm",   "because"};
  e.detail_columns = {"grasp",    "id",          "chosen",          "x_m",    "y_m",
                      "z_m",      "cost",        "share_predicted", "margin", "lifted",
                      "tilt_deg", "share_robot", "slip_mm",         "hit",    "because"};
  e.run = run;
  e.task = task();
  e.figures = figures;
  e.plot = plot;
  return e;
}

}  // namespace colift::experiments
