// Beyond the thesis: whatever fails, at whatever instant, does the job end well?

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "tools/experiments/bar_plot.hpp"
#include "tools/experiments/experiment.hpp"
#include "tools/experiments/runs/drawn_faults.hpp"
#include "tools/experiments/trials/sighting.hpp"

namespace colift::experiments {
namespace faults_trials {
namespace {

const char* word_of(control::RunRecord::Result result) {
  using Result = control::RunRecord::Result;
  return result == Result::Lifted ? "lifted" : result == Result::Aborted ? "aborted" : "refused";
}

/// Of a job that stopped, how `colift recover` ended.
std::string recovery_of(const FaultyLift& lift) {
  if (!lift.recovery) return "";
  const FaultyRecovery& r = *lift.recovery;
  if (r.home) return "home";
  return r.somebody_there ? "somebody stood there" : fmt::format("{}: {}", r.steps, r.reason);
}

TrialRows run(const Trial& trial) {
  const DrawnTrial drawn = draw_faults(trial);
  const std::string name = drawn.scene.scenario.name;
  const auto lift = run_faulty_lift(drawn.scene, config_for(trial.method, faulty_task()), trial.method,
                                    trial.own_seed(kFaultyStream));
  TrialRows rows;
  std::vector<std::string> faults;
  if (!lift) {  // a scene that cannot begin says nothing of the controller
    rows.row = {name, word(drawn.scene.wire), "", "no scene", "", "", lift.error().text(), "", cell(true)};
    rows.words = name + ": " + lift.error().text();
    return rows;
  }
  std::vector<std::string> against = objections(*lift, drawn.faults);
  if (const auto& r = lift->recovery; r && !r->home && !r->somebody_there)
    against.push_back(fmt::format("recover did not get home ({}): {}", r->steps, r->reason));
  const bool survived = against.empty();
  for (const DrawnFault& fault : drawn.faults) {
    const double began = began_s(*lift, fault);
    const std::string at = fault.in_state.empty() ? fmt::format("{:.2f} s", fault.at_s)
                                                  : fmt::format("{}+{:.2f}", fault.in_state, fault.at_s);
    faults.push_back(fmt::format("{} at {}{}", fault.what, at, std::isnan(began) ? " (not met)" : ""));
    rows.details.push_back({fault.group, fault.what, fault.in_state, cell(began), cell(survived)});
  }
  const std::string end = lift->record.states.empty() ? std::string("nothing")
                                                      : std::string(word(lift->record.states.back().state));
  rows.row = {name,
              word(drawn.scene.wire),
              fmt::format("{}", fmt::join(faults, "; ")),
              word_of(lift->record.outcome),
              end,
              fmt::format("{}", fmt::join(against, "; ")),
              lift->record.reason,
              recovery_of(*lift),
              cell(survived)};
  // what only an emulated wire or the operator does is in no scenario
  if (!survived && drawn.scene.wire == Wire::None && !drawn.scene.interrupted_s)
    rows.kept = KeptLift{drawn.scene.scenario, trial.own_seed(kFaultyStream)};
  rows.words = fmt::format("{}, {}: {} ({}){}", name, fmt::join(faults, "; "), word_of(lift->record.outcome),
                           end, survived ? "" : fmt::format("; FAILED: {}", fmt::join(against, "; ")));
  return rows;
}

Estimate survived(const TrialTable& table, const std::string& group) {
  int good = 0, n = 0;
  for (const Row& row : table.rows()) {
    if (!group.empty() && (table.text(row, "group") != group || std::isnan(table.number(row, "began_s"))))
      continue;
    ++n;
    good += table.number(row, "survived") > 0.5;
  }
  return rate(good, n);
}

Estimate recovered(const TrialTable& table) {
  int home = 0, n = 0;
  for (const Row& row : table.rows()) {
    const std::string how = table.text(row, "recovery");
    if (how.empty() || how == "somebody stood there") continue;
    ++n;
    home += how == "home";
  }
  return rate(home, n);
}

std::vector<Figure> figures(const Results& r) {
  int met = 0;
  for (const Row& row : r.details.rows()) met += !std::isnan(r.details.number(row, "began_s"));
  std::vector<Figure> out{
      {"survived", "runs that ended well", survived(r.trials, ""), "%", 1.0, true},
      {"met", "of the faults drawn, met", rate(met, static_cast<int>(r.details.rows().size())), "%"}};
  if (const Estimate home = recovered(r.trials); home.n > 0)
    out.push_back(
        {"recovered", "of those that stopped, brought home by colift recover", home, "%", 1.0, true});
  for (const std::string& group : fault_groups())
    out.push_back({"survived_" + group, "runs with a fault of " + group, survived(r.details, group), "%"});
  return out;
}

picture::Canvas plot(const Results& r) {
  BarPanel panel{"Runs that ended well (%)", {}, {}, {}};
  for (const Figure& f : figures(r))
    if (f.key.rfind("survived_", 0) == 0 && f.estimate.n > 0)
      panel.bars.push_back(percent_bar(f.key.substr(9), f.estimate));
  return draw_bar_plot({panel});
}

}  // namespace
}  // namespace faults_trials

Experiment faults_experiment() {
  using namespace faults_trials;
  Experiment e;
  e.name = "faults";
  e.title = "Up to three faults at random instants";
  e.thesis = "beyond it";
  e.question =
      "Tables, boxes, pipes and chairs are lifted while camera, arm, hand, partner, other people, things or "
      "the operator do what they should not: one to three faults, each at a random instant of a random "
      "state. A run ended well when the judge is silent, it came to an end by itself within 240 s, lifted "
      "was true where it was said, nothing moved on where a fault asked for rest, and from a stop colift "
      "recover brings the arm home with an open hand, once the causes are mended.";
  e.default_trials = 100;
  e.columns = {"layout", "rig", "faults", "outcome", "end", "against", "because", "recovery", "survived"};
  e.detail_columns = {"group", "fault", "state", "began_s", "survived"};
  e.run = run;
  e.task = faulty_task();
  e.figures = figures;
  e.plot = plot;
  return e;
}

}  // namespace colift::experiments
