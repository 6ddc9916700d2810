// Beyond the thesis: whether a second look at the same scene finds the same grasps, and how near the chosen
// one is to the best of a search at steps of millimetres.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "tools/experiments/bar_plot.hpp"
#include "tools/experiments/experiment.hpp"
#include "tools/experiments/trials/furniture.hpp"
#include "tools/experiments/trials/layouts.hpp"
#include "tools/experiments/trials/sighting.hpp"
#include "tools/experiments/trials/tried_grasps.hpp"

namespace colift::experiments {
namespace candidate_trials {
namespace {

constexpr double kLift_m = 0.05, kFine_m = 0.004;
constexpr double kSameSide = 0.966;  // cosine of 15 degrees

/// Both would put the hand to the same place, from the same side and with fingers on the same faces.
bool is_same(const planner::GraspCandidate& a, const planner::GraspCandidate& b, double within_m) {
  return (a.position - b.position).norm() <= within_m && a.approach.dot(b.approach) > kSameSide &&
         std::abs(a.closing.dot(b.closing)) > kSameSide;
}

struct FoundAgain {
  int possible = 0;  ///< At the first look.
  int again = 0;     ///< Possible at the second one too ...
  int refused = 0;   ///< ... or there, but refused.
};

FoundAgain found_again(const std::vector<planner::GraspCandidate>& first,
                       const std::vector<planner::GraspCandidate>& second, double within_m) {
  FoundAgain found;
  for (const planner::GraspCandidate& a : first) {
    if (!is_in_reach(a)) continue;
    ++found.possible;
    const auto is_there = [&](bool possible) {
      return std::any_of(second.begin(), second.end(), [&](const planner::GraspCandidate& b) {
        return is_in_reach(b) == possible && is_same(a, b, within_m);
      });
    };
    if (is_there(true))
      ++found.again;
    else if (is_there(false))
      ++found.refused;
  }
  return found;
}

struct Compared {
  FoundAgain found;
  bool both_chose = false, same_choice = false;
  double apart_m = NAN, share_apart = NAN, cost_ratio = NAN;
  std::string words;
};

Compared compare(const sim_hal::Scenario& scenario, const Trial& trial) {
  Compared out;
  const control::Config config = config_for(trial.method);
  const double half_m = 0.5 * config.candidates.step_m;
  auto one = Observation::make(scenario, trial.method, trial.own_seed(71), kLift_m);
  auto two = Observation::make(scenario, trial.method, trial.own_seed(72), kLift_m);
  if (!one || !two) {
    out.words = (one ? two : one).error().detail;
    return out;
  }
  out.found = found_again((*one)->analysis().candidates, (*two)->analysis().candidates, half_m);
  const auto mine = (*one)->decide(config), other = (*two)->decide(config);
  if (!mine || !mine->decision.chosen) {
    out.words = mine ? mine->decision.reason : mine.error().detail;
    return out;
  }
  const planner::GraspCandidate& chosen = mine->candidates[*mine->decision.chosen];
  out.both_chose = other && other->decision.chosen;
  out.same_choice = out.both_chose && is_same(chosen, other->candidates[*other->decision.chosen], half_m);
  const auto fine = (*one)->decide_finely(config, kFine_m);
  if (!fine || !fine->decision.chosen) return out;
  const planner::GraspCandidate& best = fine->candidates[*fine->decision.chosen];
  out.apart_m = (planner::load_point(chosen) - planner::load_point(best)).norm();
  out.share_apart = std::abs(mine->decision.share - fine->decision.share);
  out.cost_ratio = mine->decision.cost / fine->decision.cost;
  return out;
}

TrialRows run(const Trial& trial) {
  const int n = trial.index / 2;
  const sim_hal::Scenario scenario = seen_from(
      trial.view, trial.index % 2 == 0 ? mixed_layout(n, trial.seed) : furniture_layout(n, trial.seed));
  const Compared c = compare(scenario, trial);
  TrialRows rows;
  rows.row = {scenario.name,         cell(c.found.possible),
              cell(c.found.again),   cell(c.found.refused),
              cell(c.both_chose),    cell(c.same_choice),
              cell(1e3 * c.apart_m), cell(c.share_apart),
              cell(c.cost_ratio),    c.words};
  rows.words = fmt::format("{}: {} of {} found again, {}; {:.0f} mm from the optimum", scenario.name,
                           c.found.again, c.found.possible,
                           c.same_choice  ? "the same chosen"
                           : c.both_chose ? "another chosen"
                                          : "not chosen twice",
                           1e3 * c.apart_m);
  const double half_m = 0.5 * planner::CandidateConfig{}.step_m;
  if (c.found.again < c.found.possible || c.apart_m > half_m)
    rows.kept = KeptLift{scenario, trial.own_seed(71)};
  return rows;
}

std::vector<Figure> figures(const Results& r) {
  const double half_mm = 0.5e3 * planner::CandidateConfig{}.step_m;
  // candidates of one object are found or lost together: each object counts once
  std::vector<double> again, refused;
  int chose = 0, same = 0, decided = 0, near = 0;
  for (const Row& row : r.trials.rows()) {
    if (const double possible = r.trials.number(row, "possible"); possible > 0.0) {
      again.push_back(r.trials.number(row, "again") / possible);
      refused.push_back(r.trials.number(row, "refused") / possible);
    }
    chose += r.trials.number(row, "both_chose") > 0.5;
    same += r.trials.number(row, "same_choice") > 0.5;
    const double apart_mm = r.trials.number(row, "apart_mm");
    if (!std::isfinite(apart_mm)) continue;
    ++decided;
    near += apart_mm <= half_mm;
  }
  return {
      {"again", "possible candidates that a second look finds again, mean over objects", mean_estimate(again),
       "%", 0.95},
      {"refused", "found again, but refused there", mean_estimate(refused), "%"},
      {"same", "both looks choose: the same grasp, within half a step", rate(same, chose), "%"},
      {"near", "chosen: at most half a step from the best of a search at 4 mm", rate(near, decided), "%",
       0.95},
      {"apart", "distance from that best one, 95 % below",
       quantile_estimate(r.trials.numbers("apart_mm"), 0.95), "mm", half_mm, false},
      {"share", "difference of their shares, 95 % below",
       quantile_estimate(r.trials.numbers("share_apart"), 0.95), ""},
      {"cost", "ratio of their costs, 95 % below", quantile_estimate(r.trials.numbers("cost_ratio"), 0.95),
       ""},
  };
}

picture::Canvas plot(const Results& r) {
  BarPanel panel{"Found again, the same chosen, near the optimum (%)", {}, {}, 100.0};
  for (const Figure& f : figures(r))
    if (f.unit == "%") panel.bars.push_back(percent_bar(f.key, f.estimate));
  return draw_bar_plot({panel});
}

}  // namespace
}  // namespace candidate_trials

Experiment candidates_experiment() {
  using namespace candidate_trials;
  Experiment e;
  e.name = "candidates";
  e.title = "The same grasps at a second look, and the best one among finer steps";
  e.thesis = "beyond";
  e.question =
      "Tables, boxes, pipes, chairs and other furniture at random, each looked at twice with the camera's "
      "own noise: which possible candidates are found again within half a step and 15 degrees, whether the "
      "same one is chosen, and how far the chosen one is from the best of a search at steps of 4 mm.";
  e.default_trials = 200;
  e.columns = {"layout",      "possible", "again",       "refused",    "both_chose",
               "same_choice", "apart_mm", "share_apart", "cost_ratio", "because"};
  e.run = run;
  e.trials_set = "nothing";
  e.figures = figures;
  e.plot = plot;
  return e;
}

}  // namespace colift::experiments
