// Beyond the thesis: somebody comes into a lift. Figures are those of the simulation's judge and its world.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "tools/experiments/bar_plot.hpp"
#include "tools/experiments/experiment.hpp"
#include "tools/experiments/runs/body_in_view.hpp"
#include "tools/experiments/runs/people_scene.hpp"
#include "tools/experiments/runs/whole_lift.hpp"

namespace colift::experiments {
namespace people_trials {
namespace {

constexpr double kMostKept_n = 65.0;   // what still clamps somebody after half a second
constexpr double kSeenBefore_s = 0.5;  // in view so long before: the arm has to be at rest when he is touched

/// What the robot did to people in one lift.
struct Touches {
  int count = 0;
  /// Of the touch that is worst: first one beyond its limit that is not his own, then one that is, then the
  /// one nearest to its limit.
  std::string region;
  double peak_n = NAN, of_limit = NAN, robot_m_s = NAN, commanded_j = NAN;
  double clamped_s = 0.0, kept_n = 0.0;
  int worst = -1;  ///< 0 within, 1 his own beyond, 2 the robot's beyond.

  [[nodiscard]] const char* forces() const { return worst == 2 ? "beyond" : worst == 1 ? "own" : "within"; }
};

Touches touches(const sim_hal::Verdict& verdict) {
  Touches t;
  for (const sim_hal::JudgedContact& c : verdict.contacts) {
    // whatever pressed him, the object too; who ran into an arm at rest is counted on its own
    if (c.by == "robot" && c.person >= 0) ++t.count;
    t.clamped_s = std::max(t.clamped_s, c.clamped_s);
    t.kept_n = std::max(t.kept_n, c.kept_n);
    const double of_limit = c.counts_n / c.limit_n;
    const int kind = of_limit <= 1.0 ? 0 : c.his_own ? 1 : 2;
    if (kind < t.worst || (kind == t.worst && of_limit <= t.of_limit)) continue;
    t.worst = kind;
    t.of_limit = of_limit;
    t.peak_n = c.counts_n;
    t.robot_m_s = c.robot_m_s;
    t.commanded_j = c.commanded_j;
    t.region = (c.person < 0 ? "partner's " : "") + c.region + (c.by == "robot" ? "" : " by the object");
  }
  return t;
}

TrialRows run(const Trial& trial) {
  const PeopleTrial scene = people_trial(trial);
  const std::uint64_t seed = trial.own_seed(32);
  const sim_hal::ScenarioPerson& person = scene.scenario.people.front();
  const auto name = std::string(kPeopleScenes[static_cast<std::size_t>(scene.scene)]);
  TrialRows rows;
  rows.row = {name, scene.scenario.object.kind, person.in_state, cell(person.enters_s), cell(person.speed)};
  std::optional<BodyInView> view;
  LiftHooks hooks;
  hooks.started = [&](const sim_hal::SimWorld& world) { view.emplace(world); };
  hooks.each_frame = [&](const sim_hal::SimWorld& world, control::Task) { view->frame(world); };
  hooks.each_tick = [&](const sim_hal::TickReport& report) { view->tick(report); };
  const auto lift = run_whole_lift(scene.scenario, trial.method, seed, hooks);
  if (!lift) {
    rows.row.resize(rows.row.size() + 20);
    rows.row.push_back(lift.error().text());
    rows.words = name + ": " + lift.error().text();
    return rows;
  }
  const sim_hal::Verdict& v = lift->verdict;
  const Touches t = touches(v);
  const bool touched = view->touched_s().has_value();
  const bool in_view =
      touched && view->pixels_at(*view->touched_s() - kSeenBefore_s) >= BodyInView::kMinPixels;
  const bool rested = touched && view->rested();
  std::vector<std::string> missed = v.breaches;
  if (in_view && !rested)
    missed.push_back(fmt::format("touched at {:.2f} s by an arm at {:.2f} rad/s", *view->touched_s(),
                                 view->joint_rad_s()));
  if (t.worst == 2)
    missed.push_back(
        fmt::format("{}: {:.0f} N, {:.0f} % of its limit", t.region, t.peak_n, 100.0 * t.of_limit));
  // why, as far as the world tells, of the touch that is beyond its limit
  std::string reason;
  if (!missed.empty() && t.worst == 2)
    reason = t.commanded_j > 0.1 ? fmt::format("commands had put {:.1f} J into the arm", t.commanded_j)
                                 : "held between two sides, or pressed for more than 0.5 s";
  if (t.worst == 1) reason = "he ran into an arm that no command drove";
  if (reason.empty() && !missed.empty())
    reason = !touched  ? "nobody was touched by the robot"
             : rested  ? "the arm was at rest when he touched it"
             : in_view ? "the arm still moved"
                       : "not in view 0.5 s before, the arm moved";
  const bool came = v.min_distance_m.has_value();
  for (const std::string& text : {std::string(word(lift->record.outcome)),
                                  cell(came),
                                  cell(t.count),
                                  touched ? cell(*view->touched_s()) : std::string(),
                                  t.region,
                                  cell(t.peak_n),
                                  cell(t.of_limit),
                                  std::string(t.forces()),
                                  cell(t.clamped_s),
                                  cell(t.kept_n),
                                  cell(t.robot_m_s),
                                  cell(t.commanded_j),
                                  touched ? cell(view->joint_rad_s()) : std::string(),
                                  touched ? cell(in_view) : std::string(),
                                  touched ? cell(rested) : std::string(),
                                  cell(v.min_distance_m.value_or(NAN)),
                                  cell(v.stop_latency_s.value_or(NAN)),
                                  cell(static_cast<int>(v.breaches.size())),
                                  fmt::format("{}", fmt::join(missed, "; ")),
                                  reason,
                                  lift->record.reason})
    rows.row.push_back(text);
  if (!missed.empty() || t.worst == 1) rows.kept = KeptLift{scene.scenario, seed};
  rows.words = fmt::format("{}, {}, {}+{:.1f}: {}{}{}", name, scene.scenario.object.kind, person.in_state,
                           person.enters_s, word(lift->record.outcome),
                           missed.empty() ? "" : "; MISSED (" + reason + ") ", fmt::join(missed, "; "));
  return rows;
}

std::vector<Figure> figures(const Results& r) {
  int n = 0, came = 0, touched = 0, silent = 0, within = 0, own = 0, beyond = 0, seen = 0, rested = 0,
      kept = 0, eased = 0;
  std::vector<double> distances, latencies;
  for (const Row& row : r.trials.rows()) {
    if (r.trials.text(row, "outcome").empty()) continue;
    ++n;
    silent += r.trials.number(row, "breaches") == 0.0;
    within += r.trials.text(row, "forces") == "within";
    own += r.trials.text(row, "forces") == "own";
    beyond += r.trials.text(row, "forces") == "beyond";
    if (const double n_kept = r.trials.number(row, "kept_n"); n_kept > 0.0) {
      ++kept;
      eased += n_kept <= kMostKept_n;
    }
    if (r.trials.number(row, "came") == 0.0) continue;
    ++came;
    distances.push_back(r.trials.number(row, "min_distance_m"));
    latencies.push_back(1000.0 * r.trials.number(row, "stop_latency_s"));
    if (r.trials.text(row, "touched_s").empty()) continue;
    ++touched;
    if (r.trials.number(row, "in_view") == 0.0) continue;
    ++seen;
    rested += r.trials.number(row, "rested") != 0.0;
  }
  return {{"came", "trials in which somebody came", rate(came, n), "%"},
          {"touched", "of them: robot and he touched", rate(touched, came), "%"},
          {"at_rest", "touched, in view 0.5 s before: arm at rest", rate(rested, seen), "%", 0.99, true},
          {"within_limits", "all forces within the region's limits", rate(within, n), "%", 1.0, true},
          {"own", "beyond them by his own motion alone", rate(own, n), "%"},
          {"beyond", "beyond them, and the robot had a part in it", rate(beyond, n), "%", 0.0, false},
          {"eased", "clamped for more than 0.5 s: with at most 65 N then", rate(eased, kept), "%", 1.0, true},
          {"silent", "trials without a breach of the judge", rate(silent, n), "%", 1.0, true},
          {"distance_p05", "smallest distance, 5 % below", quantile_estimate(distances, 0.05), "m"},
          {"stop_latency_p95", "45 N to the first slower command, 95 % below",
           quantile_estimate(latencies, 0.95), "ms", 10.0, false}};
}

picture::Canvas plot(const Results& r) {
  BarPanel force{"Largest force as a fraction of its limit", {}, {}, {}},
      missed{"Trials that miss a requirement (%)", {}, {}, {}};
  for (const std::string_view scene : kPeopleScenes) {
    double worst = 0.0;
    int n = 0, bad = 0;
    for (const Row& row : r.trials.rows()) {
      if (r.trials.text(row, "scene") != scene) continue;
      ++n;
      bad += !r.trials.text(row, "missed").empty();
      const double of_limit = r.trials.number(row, "of_limit");
      if (of_limit > worst) worst = of_limit;
    }
    force.bars.push_back({std::string(scene), worst});
    missed.bars.push_back({std::string(scene), n > 0 ? 100.0 * bad / n : NAN});
  }
  return draw_bar_plot({force, missed});
}

}  // namespace
}  // namespace people_trials

Experiment people_experiment() {
  using namespace people_trials;
  Experiment e;
  e.name = "people";
  e.title = "Somebody comes into a lift";
  e.thesis = "beyond it";
  e.question =
      "A whole lift of a table, box, pipe or chair, and a person who walks or runs into the arm's path, "
      "reaches for its hand, crouches at the grasp, puts a foot under the object or a hand between the "
      "fingers, or grasps along, at a random moment of a random state. Forces, speeds and distances are "
      "those of the simulation's judge. In view: at least 10 of 160 x 120 rays of the camera meet him first.";
  e.default_trials = 1000;
  e.columns = {"scene",   "object",    "state",          "enters_s",       "speed",       "outcome",
               "came",    "touches",   "touched_s",      "region",         "peak_n",      "of_limit",
               "forces",  "clamped_s", "kept_n",         "robot_m_s",      "commanded_j", "joint_rad_s",
               "in_view", "rested",    "min_distance_m", "stop_latency_s", "breaches",    "missed",
               "reason",  "because"};
  e.run = run;
  e.figures = figures;
  e.plot = plot;
  return e;
}

}  // namespace colift::experiments
