// Thesis 6.1: does a candidate hold?

#include <fmt/format.h>

#include <array>
#include <cmath>

#include "tools/experiments/bar_plot.hpp"
#include "tools/experiments/experiment.hpp"
#include "tools/experiments/trials/layouts.hpp"
#include "tools/experiments/trials/tried_grasps.hpp"

namespace colift::experiments {
namespace grasps_trials {
namespace {

constexpr std::size_t kGrasps = 12;  // thesis: at least ten
constexpr double kHeight_m = 0.05, kHold_s = 0.5;

control::TaskSaid task() {
  return {"experiment grasps", kHeight_m, kHold_s};
}
constexpr std::array<const char*, 4> kObjects{"table", "box", "pipe", "chair"};

// in the thesis's proportion: two poses of table and box, one of pipe and chair
std::pair<const char*, sim_hal::Scenario> layout(const Trial& t) {
  const int round = t.index / 6;
  switch (t.index % 6) {
    case 0:
    case 1:
      return {"table", table_layout(2 * round + t.index % 6, t.seed)};
    case 2:
    case 3:
      return {"box", box_layout(2 * round + t.index % 6 - 2, t.seed)};
    case 4:
      return {"pipe", pipe_layout(round, t.seed)};
    default:
      return {"chair", chair_layout(round, t.seed)};
  }
}

TrialRows run(const Trial& trial) {
  const std::uint64_t seed = trial.own_seed(3);
  auto [object, scenario] = layout(trial);
  scenario = seen_from(trial.view, std::move(scenario));
  scenario.partner = {};
  scenario.partner.kind = "none";
  auto observation = Observation::make(scenario, trial.method, seed, kHeight_m);
  if (!observation)
    return {{object, scenario.name, "0", "0", "", "", "", observation.error().text()},
            {},
            observation.error().text()};

  const auto& candidates = (*observation)->analysis().candidates;
  std::vector<bool> possible(candidates.size());
  int reachable = 0;
  for (std::size_t i = 0; i < candidates.size(); ++i) {
    possible[i] = candidates[i].verdict == planner::Verdict::Ok;
    reachable += possible[i];
  }
  control::Config config = config_for(trial.method, task());
  TrialRows rows;
  int tried = 0, held = 0, lifted = 0;
  for (const std::size_t i : spread_over(candidates, possible, {}, kGrasps)) {
    const planner::GraspCandidate& c = candidates[i];
    const auto plan = (*observation)->plan(c);
    DirectLift lift;
    if (plan) {
      auto done = lift_directly(scenario, *plan, config, seed);
      if (done)
        lift = *done;
      else
        lift.reason = done.error().text();
      ++tried;
      held += lift.held;
      lifted += lift.lifted;
    } else {
      lift.reason = "no path: " + plan.error().detail;
    }
    rows.details.push_back({object, cell(c.id), cell(c.width), cell(c.stability.value_or(NAN)),
                            cell(plan.has_value()), cell(lift.held), cell(lift.lifted),
                            cell(1e3 * lift.slip_m), cell(lift.hit_something), lift.reason});
  }
  rows.row = {object,
              scenario.name,
              cell(static_cast<int>(candidates.size())),
              cell(reachable),
              cell(tried),
              cell(held),
              cell(lifted),
              tried > 0 ? "" : (*observation)->analysis().reason};
  rows.words = fmt::format("{}: {} of {} candidates within reach; {} tried, {} held, {} lifted",
                           scenario.name, reachable, candidates.size(), tried, held, lifted);
  return rows;
}

struct Count {
  int tried = 0, held = 0, lifted = 0;
};

Count count(const Results& r, const std::string& object) {
  Count c;
  for (const Row& d : r.details.rows()) {
    if (!object.empty() && r.details.text(d, "object") != object) continue;
    if (r.details.number(d, "planned") < 0.5) continue;
    ++c.tried;
    c.held += r.details.number(d, "held") > 0.5;
    c.lifted += r.details.number(d, "lifted") > 0.5;
  }
  return c;
}

std::vector<Figure> figures(const Results& r) {
  const Count all = count(r, "");
  int planned = 0;
  for (const Row& d : r.details.rows()) planned += r.details.number(d, "planned") > 0.5;
  std::vector<Figure> out{
      {"held", "grasps that held when closed", rate(all.held, all.tried), "%", 0.97, true, "about 90 %"},
      {"lifted", "... and still after a lift of 5 cm", rate(all.lifted, all.tried), "%", 0.95, true},
      {"way", "grasps within reach to which a path was found",
       rate(planned, static_cast<int>(r.details.rows().size())), "%"}};
  for (const char* object : kObjects) {
    const Count c = count(r, object);
    out.push_back(
        {fmt::format("held_{}", object), fmt::format("held, {}", object), rate(c.held, c.tried), "%"});
    out.push_back(
        {fmt::format("lifted_{}", object), fmt::format("lifted, {}", object), rate(c.lifted, c.tried), "%"});
    std::vector<double> reachable;
    for (const Row& row : r.trials.rows())
      if (r.trials.text(row, "object") == object) reachable.push_back(r.trials.number(row, "reachable"));
    out.push_back({fmt::format("reachable_{}", object),
                   fmt::format("candidates within reach, {}, median", object),
                   quantile_estimate(reachable, 0.5),
                   "",
                   {},
                   true,
                   "at least 10 tried"});
  }
  return out;
}

picture::Canvas plot(const Results& r) {
  BarPanel held{"Held when closed (%)", {}, {}, 100.0},
      lifted{"Still held after a lift of 5 cm (%)", {}, {}, 100.0};
  held.levels.push_back({"thesis: about 90 %", 90.0, picture::rgb(0xE69F00)});
  for (const char* object : kObjects) {
    const Count c = count(r, object);
    const auto bar = [&](int good) {
      const Estimate e = rate(good, c.tried);
      return Bar{object, 100 * e.value, false, 100 * e.low, 100 * e.high};
    };
    held.bars.push_back(bar(c.held));
    lifted.bars.push_back(bar(c.lifted));
  }
  return draw_bar_plot({held, lifted});
}

}  // namespace
}  // namespace grasps_trials

Experiment grasps_experiment() {
  using namespace grasps_trials;
  Experiment e;
  e.name = "grasps";
  e.title = "Verification of candidate grasps";
  e.thesis = "6.1";
  e.question =
      "A table, box, pipe or chair that nobody else holds. Up to twelve grasps that the arm reaches, spread "
      "over the "
      "object, are tried one at a time, each in a world of its own: open, approach, close; then a lift of 5 "
      "cm.";
  e.default_trials = 42;
  e.columns = {"object", "layout", "candidates", "reachable", "tried", "held", "lifted", "because"};
  e.detail_columns = {"object", "id",     "width_m", "margin", "planned",
                      "held",   "lifted", "slip_mm", "hit",    "because"};
  e.run = run;
  e.task = task();
  e.figures = figures;
  e.plot = plot;
  return e;
}

}  // namespace colift::experiments
