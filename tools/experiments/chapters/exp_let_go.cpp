// Beyond the thesis: is a partner who lets go noticed, whenever he does?

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "sim_hal/synthetic/hash_random.hpp"
#include "tools/experiments/bar_plot.hpp"
#include "tools/experiments/experiment.hpp"
#include "tools/experiments/runs/whole_lift.hpp"
#include "tools/experiments/trials/layouts.hpp"

namespace colift::experiments {
namespace let_go_trials {
namespace {

using control::Task;

constexpr double kHeight_m = 0.05, kHold_s = 1.0;
constexpr double kSoon_ms = 150.0;
constexpr double kPaused_s = 3.0;    // who grasps again does so for half a second
constexpr double kStands_m = 0.001;  // of the object over where it stood
constexpr const char* kEarly = "though nobody had let go, ";
constexpr Task kLoaded[] = {Task::Close, Task::Verify, Task::AwaitReady, Task::Lift, Task::Hold, Task::Lower};

control::TaskSaid task() {
  return {"experiment let-go", kHeight_m, kHold_s};
}

/// What the job did first after a time, and how long after it (ms); NaN: nothing to the end.
struct Reaction {
  double after_ms = NAN;
  std::string state, why;
};

bool speaks_of_let_go(const control::StateChange& s) {
  return s.state == Task::Pause || s.reason.find("let go") != std::string::npos;
}

// a state that the lift without the event would have entered anyway is none
bool is_reaction(const control::StateChange& s) {
  return speaks_of_let_go(s) || s.state == Task::Stopped || s.state == Task::Yield;
}

Reaction reaction(const control::RunRecord& record, double at_s) {
  for (const control::StateChange& s : record.states) {
    const double t = hal::seconds(s.at);
    if (t >= at_s && is_reaction(s)) return {1e3 * (t - at_s), std::string(word(s.state)), s.reason};
  }
  return {};
}

/// Of a job that did not come to the state in which he lets go: whether he was believed to have done it.
std::string believed_let_go(const control::RunRecord& record) {
  for (const control::StateChange& s : record.states)
    if (speaks_of_let_go(s))
      return fmt::format("{}{} at {:.2f} s: {}", kEarly, word(s.state), hal::seconds(s.at), s.reason);
  return record.reason;
}

// An instant from the first closing to the end of lowering, as a state and a time in it. Where a state is
// shorter than here, the instant is in the next one.
struct Phase {
  Task task;
  double length_s;
};
constexpr Phase kPhases[] = {{Task::Close, 1.2}, {Task::Verify, 0.3},   {Task::AwaitReady, 0.5},
                             {Task::Lift, 2.3},  {Task::Hold, kHold_s}, {Task::Lower, 3.0}};

sim_hal::PartnerScriptEvent let_go_at(double fraction) {
  double total_s = 0.0;
  for (const Phase& p : kPhases) total_s += p.length_s;
  double left_s = fraction * total_s;
  for (const Phase& p : kPhases) {
    if (left_s <= p.length_s) return {left_s, "let-go", {}, std::string(word(p.task))};
    left_s -= p.length_s;
  }
  return {kPhases[5].length_s, "let-go", {}, std::string(word(Task::Lower))};
}

TrialRows run(const Trial& trial) {
  const std::uint64_t seed = trial.own_seed(11);
  sim_hal::Draws draws(seed, 8100);
  sim_hal::Scenario scenario = mixed_layout(trial.index, trial.seed);
  scenario.task.height = kHeight_m;
  scenario.task.hold_s = kHold_s;
  const sim_hal::PartnerScriptEvent event = let_go_at(draws.between(0.0, 1.0));
  scenario.partner.events.push_back(event);
  const auto without = [&](const std::string& why) {
    return TrialRows{{scenario.name, "", "", "", "", "", "", why}, {}, scenario.name + ": " + why};
  };
  LiftHooks hooks;
  hooks.cut = {.at_release_before_lift = true, .paused_s = kPaused_s};
  const auto lift = run_whole_lift(scenario, trial.method, seed, hooks);
  if (!lift) return without(lift.error().text());
  double at_s = NAN;
  for (const control::StateChange& s : lift->record.states)
    if (word(s.state) == event.in_state) {
      at_s = hal::seconds(s.at) + event.at_s;
      break;
    }
  if (std::isnan(at_s)) return without("never in " + event.in_state + ": " + believed_let_go(lift->record));
  std::string in;
  for (const control::StateChange& s : lift->record.states)
    if (hal::seconds(s.at) <= at_s) in = word(s.state);
  if (std::none_of(std::begin(kLoaded), std::end(kLoaded), [&](Task t) { return word(t) == in; }))
    return without("let go in " + in);
  // from there on nobody needs him
  const bool stands = in == word(Task::Lower) && lift->height_at_let_go_m < kStands_m;
  if (stands) return without("let go after the object stood");
  const Reaction r = reaction(lift->record, at_s);
  const bool lifted = lift->record.outcome == control::RunRecord::Result::Lifted;
  TrialRows rows;
  rows.row = {scenario.name,    in,
              cell(at_s),       cell(1e3 * lift->height_at_let_go_m),
              cell(r.after_ms), r.state + ": " + r.why,
              cell(lifted),     lift->record.reason};
  if (lifted || !(r.after_ms <= kSoon_ms)) rows.kept = KeptLift{scenario, seed};
  rows.words =
      fmt::format("{}, {} at {:.2f} s: {}{}", scenario.name, in, at_s,
                  std::isnan(r.after_ms) ? "not noticed"
                                         : fmt::format("{} after {:.0f} ms: {}", r.state, r.after_ms, r.why),
                  lifted ? ", REPORTED LIFTED" : "");
  return rows;
}

std::vector<double> times(const Results& r, const std::string& state) {
  std::vector<double> out;
  for (const Row& row : r.trials.rows()) {
    if (r.trials.text(row, "state").empty()) continue;
    if (!state.empty() && r.trials.text(row, "state") != state) continue;
    const double ms = r.trials.number(row, "noticed_ms");
    out.push_back(std::isnan(ms) ? 1e6 : ms);
  }
  return out;
}

std::vector<Figure> figures(const Results& r) {
  int lifted = 0, n = 0, early = 0;
  for (const Row& row : r.trials.rows()) {
    early += r.trials.text(row, "because").find(kEarly) != std::string::npos;
    if (r.trials.text(row, "state").empty()) continue;
    ++n;
    lifted += r.trials.number(row, "lifted") > 0.5;
  }
  const std::vector<double> all = times(r, "");
  const auto soon =
      static_cast<int>(std::count_if(all.begin(), all.end(), [](double t) { return t <= kSoon_ms; }));
  std::vector<Figure> out{
      {"lifted", "reported as lifted", rate(lifted, n), "%", 0.0, false},
      {"soon", "noticed within 150 ms", rate(soon, n), "%", 0.99, true},
      {"early", "stopped though nobody had let go yet", rate(early, n + early), "%"},
      {"p50", "time to notice, median", quantile_estimate(all, 0.5), "ms"},
      {"p99", "time to notice, 99 % below", quantile_estimate(all, 0.99), "ms", kSoon_ms, false}};
  for (const Task t : kLoaded) {
    const std::string name(word(t));
    out.push_back({"p50_" + name, "in " + name + ", median", quantile_estimate(times(r, name), 0.5), "ms"});
  }
  return out;
}

picture::Canvas plot(const Results& r) {
  BarPanel panel{"Time to notice, median (ms)", {}, {}, {}};
  for (const Figure& f : figures(r))
    if (f.key.rfind("p50_", 0) == 0 && f.estimate.n > 0)
      panel.bars.push_back({f.key.substr(4), f.estimate.value, false, f.estimate.low, f.estimate.high});
  return draw_bar_plot({panel});
}

}  // namespace
}  // namespace let_go_trials

Experiment let_go_experiment() {
  using namespace let_go_trials;
  Experiment e;
  e.name = "let-go";
  e.title = "A partner who lets go at a random instant";
  e.thesis = "beyond it";
  e.question =
      "Tables, boxes, pipes and chairs are lifted, and the partner lets go at an instant drawn between the "
      "hand's first closing and the end of lowering. When is it noticed, and is the lift called lifted? A "
      "let-go after the object stands again is none.";
  e.default_trials = 100;
  e.columns = {"layout", "state", "at_s", "height_mm", "noticed_ms", "reaction", "lifted", "because"};
  e.run = run;
  e.task = task();
  e.figures = figures;
  e.plot = plot;
  return e;
}

}  // namespace colift::experiments
