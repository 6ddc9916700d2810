// Beyond the thesis: does the predicted margin tell which grasps slip?

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "planner/grasp/grasp_stability.hpp"
#include "sim_hal/synthetic/hash_random.hpp"
#include "tools/experiments/experiment.hpp"
#include "tools/experiments/trials/layouts.hpp"
#include "tools/experiments/trials/tried_grasps.hpp"
#include "tools/visualization/line_plot.hpp"
#include "tools/visualization/palette.hpp"

namespace colift::experiments {
namespace slip_trials {
namespace {

constexpr std::size_t kGrasps = 4;
constexpr double kSlip_m = 0.005;  // of the object in the hand: the grip slips
constexpr double kHeight_m = 0.05, kHold_s = 1.0;

control::TaskSaid task() {
  return {"experiment slip", kHeight_m, kHold_s};
}
constexpr double kArm_n = 55.0;  // what the arm bears beside its hand

TrialRows run(const Trial& trial) {
  const std::uint64_t seed = trial.own_seed(8);
  sim_hal::Draws draws(seed, 7800);
  const int kind = trial.index % 3;
  sim_hal::Scenario scenario = kind == 0   ? table_layout(trial.index / 3 + 2, trial.seed)
                               : kind == 1 ? box_layout(trial.index / 3 + 1, trial.seed)
                                           : pipe_layout(trial.index / 3 + 1, trial.seed);
  scenario.object.friction = draws.between(0.15, 0.9);
  scenario.object.mass = draws.between(2.0, 10.0);
  const auto refused = [&](const std::string& why) {
    return TrialRows{
        {scenario.name, cell(scenario.object.mass), cell(scenario.object.friction), "0", "0", why},
        {},
        scenario.name + ": " + why};
  };
  auto observation = Observation::make(scenario, trial.method, seed, kHeight_m);
  if (!observation) return refused(observation.error().text());
  const control::Config config =
      config_for(trial.method, task(), {{"decision.mass_kg", fmt::format("{}", scenario.object.mass)}});
  const auto outcome = (*observation)->decide(config);
  if (!outcome) return refused(outcome.error().text());
  const auto& candidates = outcome->candidates;
  std::vector<bool> possible(candidates.size());
  for (std::size_t i = 0; i < candidates.size(); ++i) {
    using planner::Verdict;
    const Verdict v = candidates[i].verdict;
    // a load beyond the arm's says nothing about the hand
    possible[i] = (v == Verdict::Ok || v == Verdict::Chosen || v == Verdict::OverLimit) &&
                  outcome->decision.scores[i] &&
                  outcome->decision.scores[i]->wrenches.robot.force.norm() < kArm_n;
  }
  planner::HandModel hand = shared_hand(trial.method).hand;
  hand.friction = scenario.object.friction;
  hand.finger_force_n = planner::fingertip_force(hand, config.task.close_torque_nm);
  TrialRows rows;
  int tried = 0, slipped = 0;
  for (const std::size_t i : spread_over(candidates, possible, {}, kGrasps)) {
    const auto margin = planner::stability_margins(
        candidates[i], hand, planner::load_on_robot(outcome->decision.scores[i]->wrenches));
    const DirectLift lift = try_grasp(**observation, scenario, candidates[i], config, seed);
    if (!lift.held || std::isnan(lift.slip_m)) continue;
    const bool slip = !lift.lifted || lift.slip_m > kSlip_m;
    ++tried;
    slipped += slip;
    rows.details.push_back({cell(candidates[i].id), planner::name_of(candidates[i].kind), cell(margin.slip),
                            cell(margin.bear), cell(1e3 * lift.slip_m), cell(slip), lift.reason});
  }
  rows.row = {scenario.name,
              cell(scenario.object.mass),
              cell(scenario.object.friction),
              cell(tried),
              cell(slipped),
              ""};
  rows.words = fmt::format("{}, {:.1f} kg, friction {:.2f}: {} of {} slipped", scenario.name,
                           scenario.object.mass, scenario.object.friction, slipped, tried);
  return rows;
}

void split(const Results& r, std::vector<double>& good, std::vector<double>& bad) {
  for (const Row& d : r.details.rows())
    (r.details.number(d, "slipped") > 0.5 ? bad : good).push_back(r.details.number(d, "margin"));
}

std::vector<Figure> figures(const Results& r) {
  std::vector<double> good, bad;
  split(r, good, bad);
  const int below =
      static_cast<int>(std::count_if(good.begin(), good.end(), [](double m) { return m < 1.0; }));
  const int above =
      static_cast<int>(std::count_if(bad.begin(), bad.end(), [](double m) { return m >= 1.0; }));
  return {
      {"auc", "area under the curve, margin against slip", area_under_curve(good, bad), "", 0.9, true},
      {"slipped", "grasps that slipped by more than 5 mm",
       rate(static_cast<int>(bad.size()), static_cast<int>(good.size() + bad.size())), "%"},
      {"held_below_1", "of those that held, margin below 1", rate(below, static_cast<int>(good.size())), "%"},
      {"slipped_above_1", "of those that slipped, margin 1 or more",
       rate(above, static_cast<int>(bad.size())), "%"}};
}

picture::Canvas plot(const Results& r) {
  std::vector<double> good, bad;
  split(r, good, bad);
  picture::PlotLine line{"margin", picture::kRobot, {0.0}, {0.0}};
  std::vector<double> at = bad;
  at.insert(at.end(), good.begin(), good.end());
  std::sort(at.begin(), at.end());
  for (const double m : at) {
    const auto part = [&](const std::vector<double>& v) {
      return v.empty()
                 ? 0.0
                 : static_cast<double>(std::count_if(v.begin(), v.end(), [&](double x) { return x <= m; })) /
                       static_cast<double>(v.size());
    };
    line.x.push_back(100 * part(good));
    line.y.push_back(100 * part(bad));
  }
  picture::LinePlot plot;
  plot.x_title = "grasps that hold and would be refused (%)";
  plot.x_low = 0.0;
  plot.x_high = 100.0;
  plot.panel_height = 420;
  picture::PlotPanel panel;
  panel.title = "Grasps that slip and would be refused (%)";
  panel.lines.push_back(std::move(line));
  panel.y_low = 0.0;
  panel.y_high = 100.0;
  plot.panels.push_back(std::move(panel));
  return picture::draw_line_plot(plot);
}

}  // namespace
}  // namespace slip_trials

Experiment slip_experiment() {
  using namespace slip_trials;
  Experiment e;
  e.name = "slip";
  e.title = "Predicted margin against simulated slip";
  e.thesis = "beyond it";
  e.question =
      "Tables, boxes and pipes of random weight and friction, with a partner. Four grasps each are lifted; "
      "the margin against slipping that is predicted for the decided load, with the true friction and the "
      "force that fingers close with, is compared with the slip in the hand.";
  e.default_trials = 90;
  e.columns = {"layout", "mass_kg", "friction", "tried", "slipped", "because"};
  e.detail_columns = {"id", "kind", "margin", "bear_margin", "slip_mm", "slipped", "because"};
  e.run = run;
  e.task = task();
  e.trials_set = "decision.mass_kg";
  e.figures = figures;
  e.plot = plot;
  return e;
}

}  // namespace colift::experiments
