// Beyond the thesis: lifts beside which nobody comes. How often does a monitor stop one, what does it cost?

#include <fmt/format.h>

#include <cmath>

#include "tools/experiments/bar_plot.hpp"
#include "tools/experiments/experiment.hpp"
#include "tools/experiments/runs/whole_lift.hpp"
#include "tools/experiments/trials/layouts.hpp"

namespace colift::experiments {
namespace false_stops_trials {
namespace {

using control::Task;
using Lifted = control::RunRecord::Result;

constexpr double kLonger = 1.10;  // times the duration without monitors

// the first stop that a lift beside which nobody comes has no reason for; empty: none
std::string stop(const control::RunRecord& record) {
  for (const control::StateChange& s : record.states)
    if (s.state == Task::Pause || s.state == Task::Yield)
      return fmt::format("{}: {}", control::word(s.state), s.reason);
  for (const control::DeviceNote& note : record.faults)
    if (note.device == "monitor" && record.monitor.stops > 0) return "hold: " + note.what;
  return record.monitor.stops > 0 ? "hold" : "";
}

// for how long and for whom the arm was slower than planned; empty: for nobody
std::string slowed(const control::RunRecord& record) {
  double slow_s = 0.0;
  control::SeparationSample worst;
  const auto& curve = record.monitor.curve;
  for (std::size_t i = 1; i < curve.size(); ++i) {
    if (curve[i].scale >= 1.0) continue;
    slow_s += curve[i].t_s - curve[i - 1].t_s;
    if (curve[i].scale < worst.scale) worst = curve[i];
  }
  if (slow_s == 0.0) return "";
  return fmt::format("slowed for {:.1f} s, at {:.1f} s to {:.0f} %: partner at {:.2f} m, others at {:.2f} m",
                     slow_s, worst.t_s, 100.0 * worst.scale, worst.partner_distance_m, worst.distance_m);
}

double took_s(const control::RunRecord& record) {
  return record.states.empty() ? NAN : hal::seconds(record.states.back().at - record.states.front().at);
}

TrialRows run(const Trial& trial) {
  const sim_hal::Scenario scenario = mixed_layout(trial.index, trial.seed);
  const std::uint64_t seed = trial.own_seed(41);
  LiftHooks without;
  without.without_monitor = true;
  const auto lift = run_whole_lift(scenario, trial.method, seed);
  const auto bare = run_whole_lift(scenario, trial.method, seed, without);
  const std::string& object = scenario.object.kind;
  if (!lift || !bare) {
    const std::string why = (lift ? bare : lift).error().text();
    return {{object, "", "", "", "", "", "", "", why}, {}, object + ": " + why};
  }
  const std::string stopped = stop(lift->record);
  const double s = took_s(lift->record), bare_s = took_s(bare->record);
  const bool both = lift->record.outcome == Lifted::Lifted && bare->record.outcome == Lifted::Lifted;
  TrialRows rows{
      {object, word(bare->record.outcome), word(lift->record.outcome), cell(!stopped.empty()), cell(s),
       cell(bare_s), both ? cell(s / bare_s) : "", cell(static_cast<int>(lift->verdict.breaches.size())),
       stopped.empty() ? slowed(lift->record) : stopped},
      {},
      fmt::format("{}: {} in {:.1f} s, {:.1f} s without monitors{}", object, word(lift->record.outcome), s,
                  bare_s, stopped.empty() ? "" : "; STOPPED " + stopped)};
  if (!stopped.empty()) rows.kept = KeptLift{scenario, seed};
  return rows;
}

std::vector<Figure> figures(const Results& r) {
  int n = 0, stops = 0, lost = 0, could = 0, silent = 0;
  std::vector<double> longer;
  for (const Row& row : r.trials.rows()) {
    const std::string bare = r.trials.text(row, "without");
    if (bare.empty()) continue;
    ++n;
    stops += r.trials.number(row, "stopped") > 0.5;
    silent += r.trials.number(row, "breaches") == 0.0;
    if (bare != "lifted") continue;
    ++could;
    lost += r.trials.text(row, "outcome") != "lifted";
    const double ratio = r.trials.number(row, "time_ratio");
    if (!std::isnan(ratio)) longer.push_back(ratio);
  }
  return {{"stopped", "lifts with a false stop", rate(stops, n), "%", 0.01, false},
          {"lost", "lifted without monitors, not with them", rate(lost, could), "%", 0.01, false},
          {"time_ratio", "time with monitors over time without, median", quantile_estimate(longer, 0.5), "",
           kLonger, false},
          {"time_ratio_p95", "the same, 95 % below", quantile_estimate(longer, 0.95), "", kLonger, false},
          {"silent", "lifts without a breach of the judge", rate(silent, n), "%", 1.0, true}};
}

picture::Canvas plot(const Results& r) {
  BarPanel time{"Time with monitors over time without", {}, {}, {}};
  for (const char* kind : {"table", "box", "cylinder", "chair"}) {
    std::vector<double> ratios;
    for (const Row& row : r.trials.rows()) {
      const double ratio = r.trials.number(row, "time_ratio");
      if (r.trials.text(row, "object") == kind && !std::isnan(ratio)) ratios.push_back(ratio);
    }
    if (!ratios.empty()) time.bars.push_back({kind, quantile_estimate(ratios, 0.5).value});
  }
  return draw_bar_plot({time});
}

}  // namespace
}  // namespace false_stops_trials

Experiment false_stops_experiment() {
  using namespace false_stops_trials;
  Experiment e;
  e.name = "false-stops";
  e.title = "Lifts beside which nobody comes";
  e.thesis = "beyond it";
  e.question =
      "Tables, boxes, pipes and chairs are lifted, each once with the monitors of people and force and once "
      "without them. A pause, a yield or a hold is a false stop. How often, and how much time do the "
      "monitors cost?";
  e.default_trials = 400;
  e.columns = {"object", "without",    "outcome",  "stopped", "took_s",
               "bare_s", "time_ratio", "breaches", "because"};
  e.run = run;
  e.trials_set = "monitor.on and monitor.force.on in the lift without monitoring, at full speed";
  e.figures = figures;
  e.plot = plot;
  return e;
}

}  // namespace colift::experiments
