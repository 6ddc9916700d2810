// Beyond the thesis: a thread of a real-time run stops. Is the arm at rest soon?

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>

#include "sim_hal/synthetic/hash_random.hpp"
#include "tools/experiments/bar_plot.hpp"
#include "tools/experiments/experiment.hpp"
#include "tools/experiments/runs/stalled_run.hpp"

namespace colift::experiments {
namespace stalls_trials {
namespace {

/// A state in which the arm moves, and how long it does so at least in the built-in lift.
struct Moving {
  const char* state;
  double lasts_s;
};
constexpr Moving kMoving[] = {{"approach", 4.0}, {"lift", 1.8}, {"lower", 1.8}, {"retreat", 3.5}};
constexpr const char* kThreads[] = {"task", "task", "colift-arm", "colift-hand", "other"};

Stall draw(const Trial& trial) {
  sim_hal::Draws draws(trial.own_seed(14), 8300);
  Stall stall;
  stall.thread = kThreads[draws.below(static_cast<int>(std::size(kThreads)))];
  const Moving& moving = kMoving[draws.below(static_cast<int>(std::size(kMoving)))];
  stall.state = moving.state;
  stall.delay_s = draws.between(0.05, moving.lasts_s);
  stall.held_s = draws.chance(0.5) ? 0.8 : 1.5;
  return stall;
}

TrialRows run(const Trial& trial) {
  const Stall stall = draw(trial);
  const auto done = run_stalled(stall, trial.own_seed(15));
  StalledRun r;
  if (done)
    r = *done;
  else
    r.because = done.error().text();
  TrialRows rows;
  rows.row = {stall.thread,    stall.state,    cell(stall.delay_s), cell(stall.held_s), r.verdict,
              cell(r.moved_s), cell(r.fast_s), cell(r.speed_rad_s), cell(r.gap_s),      r.end,
              r.because};
  rows.words = fmt::format("{} at {}+{:.2f}: {}, at rest after {:.3f} s from {:.2f} rad/s ({})", stall.thread,
                           stall.state, stall.delay_s, r.verdict, r.moved_s, r.speed_rad_s, r.end);
  return rows;
}

bool is_judged(const std::string& verdict) {
  return verdict == "stopped" || verdict == "late";
}

std::vector<double> times(const Results& r, const char* column, const std::string& thread = "") {
  std::vector<double> out;
  for (const Row& row : r.trials.rows())
    if (is_judged(r.trials.text(row, "verdict")) &&
        (thread.empty() || r.trials.text(row, "thread") == thread))
      out.push_back(r.trials.number(row, column));
  return out;
}

std::vector<Figure> figures(const Results& r) {
  const auto in_time = [](const std::vector<double>& all) {
    return rate(
        static_cast<int>(std::count_if(all.begin(), all.end(), [](double t) { return t <= kRestWithin_s; })),
        static_cast<int>(all.size()));
  };
  int machine = 0;
  for (const Row& row : r.trials.rows()) machine += r.trials.text(row, "verdict") == "machine";
  const std::vector<double> all = times(r, "moved_s");
  std::vector<Figure> out{
      {"in_time", "at rest within 0.3 s", in_time(all), "%", 1.0, true},
      {"worst_s", "longest", quantile_estimate(all, 1.0), "s", kRestWithin_s, false},
      {"p50_s", "median", quantile_estimate(all, 0.5), "s"},
      {"slow_s", "slower than 0.05 rad/s, longest", quantile_estimate(times(r, "fast_s"), 1.0), "s"},
      {"machine", "not judged: the machine itself was stalled",
       rate(machine, static_cast<int>(r.trials.rows().size())), "%"}};
  for (const char* thread : {"task", "colift-arm", "colift-hand", "other"})
    out.push_back({fmt::format("in_time_{}", thread), fmt::format("of {}", thread),
                   in_time(times(r, "moved_s", thread)), "%"});
  return out;
}

picture::Canvas plot(const Results& r) {
  BarPanel panel{"At rest after, median (s)", {}, {}, {}};
  for (const char* thread : {"task", "colift-arm", "colift-hand", "other"}) {
    const Estimate e = quantile_estimate(times(r, "moved_s", thread), 0.5);
    if (e.n > 0) panel.bars.push_back({thread, e.value, false, e.low, e.high});
  }
  return draw_bar_plot({panel});
}

}  // namespace
}  // namespace stalls_trials

Experiment stalls_experiment() {
  using namespace stalls_trials;
  Experiment e;
  e.name = "stalls";
  e.title = "A thread of a run stops";
  e.thesis = "beyond it";
  e.question =
      "A table is lifted in real time on emulated devices by a run in a process of its own; one of its "
      "threads is stopped at a random instant in which the arm moves. When is the arm at rest? Standstills "
      "of the machine are told apart.";
  e.default_trials = 20;
  e.times_computing = true;
  e.real_time = true;
  e.columns = {"thread", "state",       "delay_s", "held_s", "verdict", "moved_s",
               "fast_s", "speed_rad_s", "gap_s",   "end",    "because"};
  e.run = run;
  e.figures = figures;
  e.plot = plot;
  return e;
}

}  // namespace colift::experiments
