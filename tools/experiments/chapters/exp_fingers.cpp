// Beyond the thesis: something as thick as a finger between the hand's fingers and the object.

#include <fmt/format.h>

#include <algorithm>

#include "sim_hal/synthetic/hash_random.hpp"
#include "tools/experiments/bar_plot.hpp"
#include "tools/experiments/experiment.hpp"
#include "tools/experiments/runs/thing_between.hpp"
#include "tools/experiments/runs/whole_lift.hpp"
#include "tools/experiments/trials/layouts.hpp"

namespace colift::experiments {
namespace fingers_trials {
namespace {

using control::Task;

constexpr double kSameGrasp_m = 0.002;

TrialRows run(const Trial& trial) {
  const std::uint64_t seed = trial.own_seed(51);
  sim_hal::Draws draws(seed, 9100);
  const auto place =
      static_cast<Under>(std::min(static_cast<int>(kUnder * draws.between(0.0, 1.0)), kUnder - 1));
  sim_hal::Scenario scenario = mixed_layout(trial.index, trial.seed);
  const std::string& object = scenario.object.kind;
  const auto without = [&](const std::string& why) {
    return TrialRows{{object, word(place), "", "", "", "", why}, {}, object + ": " + why};
  };
  LiftHooks hooks;
  hooks.cut.at = {Task::AwaitReady, Task::Release};
  const auto nominal = run_whole_lift(scenario, trial.method, seed, hooks);
  if (!nominal) return without(nominal.error().text());
  const FirstGrip alone = first_grip(nominal->record);
  if (!alone.grasp) return without("no grip: " + nominal->record.reason);
  const auto thing = thing_between(*alone.grasp, shared_hand(trial.method).hand, place, alone.close_s);
  if (!thing) return without("no such thing can lie there");
  scenario.clutter.push_back(*thing);
  const auto lift = run_whole_lift(scenario, trial.method, seed, hooks);
  if (!lift) return without(lift.error().text());
  const FirstGrip grip = first_grip(lift->record);
  if (!grip.grasp || (grip.grasp->position - alone.grasp->position).norm() > kSameGrasp_m)
    return without("with the thing another grasp was chosen: " + lift->record.reason);
  const bool wraps = grip.grasp->kind == planner::GraspKind::Wrap;
  TrialRows rows;
  rows.row = {object,
              word(place),
              wraps ? "wrap" : "pinch",
              cell(1e3 * grip.grasp->width),
              cell(!grip.accepted),
              cell(!alone.accepted),
              grip.accepted ? "" : grip.why};
  if (grip.accepted) rows.kept = KeptLift{scenario, seed};
  rows.words = fmt::format("{}, under {}: {}{}", object, word(place),
                           grip.accepted ? "NOT FOUND" : "found: " + grip.why,
                           alone.accepted ? "" : "; without it, too: " + alone.why);
  return rows;
}

std::vector<Figure> figures(const Results& r) {
  int n = 0, found = 0, named = 0, false_alarms = 0, pinches = 0, pinches_found = 0;
  for (const Row& row : r.trials.rows()) {
    if (r.trials.text(row, "found").empty()) continue;
    ++n;
    const bool is_found = r.trials.number(row, "found") > 0.5;
    found += is_found;
    named += r.trials.text(row, "because").find("between") != std::string::npos;
    false_alarms += r.trials.number(row, "without_too") > 0.5;
    if (r.trials.text(row, "grip") != "pinch") continue;
    ++pinches;
    pinches_found += is_found;
  }
  return {{"found", "a thing of 20 mm is not gripped with the object", rate(found, n), "%", 0.95, true},
          {"found_pinch", "of grips between pads", rate(pinches_found, pinches), "%"},
          {"named", "and said to be between fingers and object", rate(named, found), "%"},
          {"without", "grips that are refused without it, too", rate(false_alarms, n), "%"}};
}

picture::Canvas plot(const Results& r) {
  BarPanel panel{"Found (%)", {}, {}, {}};
  for (const char* kind : {"table", "box", "cylinder", "chair"}) {
    int n = 0, found = 0;
    for (const Row& row : r.trials.rows()) {
      if (r.trials.text(row, "object") != kind || r.trials.text(row, "found").empty()) continue;
      ++n;
      found += r.trials.number(row, "found") > 0.5;
    }
    if (n > 0) panel.bars.push_back({kind, 100.0 * found / n});
  }
  return draw_bar_plot({panel});
}

}  // namespace
}  // namespace fingers_trials

Experiment fingers_experiment() {
  using namespace fingers_trials;
  Experiment e;
  e.name = "fingers";
  e.title = "A finger between the hand and the object";
  e.thesis = "beyond it";
  e.question =
      "The hand closes on tables, boxes, pipes and chairs, each once as it is and once with a rod of 20 mm "
      "on the object under one or two of its fingers. Does it open again?";
  e.default_trials = 200;
  e.columns = {"object", "place", "grip", "width_mm", "found", "without_too", "because"};
  e.run = run;
  e.figures = figures;
  e.plot = plot;
  return e;
}

}  // namespace colift::experiments
