// Thesis 6.3.3: does the chosen grasp bear the part of the load that was wanted?

#include <fmt/format.h>

#include <array>
#include <cmath>

#include "hal/types/units.hpp"
#include "tools/experiments/bar_plot.hpp"
#include "tools/experiments/experiment.hpp"
#include "tools/experiments/trials/box_in_line.hpp"
#include "tools/experiments/trials/layouts.hpp"
#include "tools/experiments/trials/tried_grasps.hpp"
#include "tools/visualization/palette.hpp"

namespace colift::experiments {
namespace load_trials {
namespace {

constexpr std::array<double, 3> kWanted{0.30, 0.50, 0.67};
constexpr std::array<const char*, 3> kName{"30", "50", "67"};
constexpr std::size_t kGrasps = 7;  // thesis: 6
constexpr double kNear = 0.02;      // of the load: closer than that two grasps are equally good
constexpr double kShareError = 0.05;
constexpr double kHeight_m = 0.05, kHold_s = 1.0;

control::TaskSaid task() {
  return {"experiment load", kHeight_m, kHold_s};
}
constexpr std::size_t kColumns = 7;  // of one wanted share

// nothing of the asked shares was tried
Row empty_row(const std::string& name, double mass,
              const std::array<std::optional<std::string>, kWanted.size()>& forbidden,
              const std::string& why) {
  Row row{name, cell(mass), "", ""};
  for (const auto& not_asked : forbidden) {
    row.push_back(cell(!not_asked));
    row.resize(row.size() + kColumns - 1);
  }
  row.push_back(why);
  return row;
}

TrialRows run(const Trial& trial) {
  const std::uint64_t seed = trial.own_seed(2);
  // boxes are laid out for each share in turn; the others are asked for where that box permits them
  const double laid_out_for = kWanted[static_cast<std::size_t>(trial.index) % kWanted.size()];
  const sim_hal::Scenario scenario =
      seen_from(trial.view, box_in_line(trial.index, trial.seed, laid_out_for));
  std::array<std::optional<std::string>, kWanted.size()> forbidden;
  for (std::size_t w = 0; w < kWanted.size(); ++w) forbidden[w] = share_forbidden(scenario, kWanted[w]);
  const auto refused = [&](const std::string& why) {
    return TrialRows{
        empty_row(scenario.name, scenario.object.mass, forbidden, why), {}, scenario.name + ": " + why};
  };
  auto observation = Observation::make(scenario, trial.method, seed, kHeight_m);
  if (!observation) return refused(observation.error().text());

  // one list of grasps for all wanted shares: those of the look, then each share's own choice
  std::vector<planner::GraspCandidate> grasps = (*observation)->analysis().candidates;
  std::vector<bool> possible(grasps.size());
  for (std::size_t i = 0; i < grasps.size(); ++i)
    possible[i] = grasps[i].verdict == planner::Verdict::Ok &&
                  (grasps[i].position - (*observation)->partner()->position).norm() > 0.15;
  std::array<std::optional<std::size_t>, 3> chosen;
  std::array<double, 3> predicted{NAN, NAN, NAN};
  std::string why;
  for (std::size_t w = 0; w < kWanted.size(); ++w) {
    if (forbidden[w]) continue;
    const auto outcome =
        (*observation)
            ->decide(config_for(trial.method, {}, {{"decision.share", fmt::format("{}", kWanted[w])}}));
    if (!outcome) return refused(outcome.error().text());
    if (!outcome->decision.chosen) {
      why = fmt::format("{} %: {}", kName[w], outcome->decision.reason);
      continue;
    }
    predicted[w] = outcome->decision.share;
    chosen[w] = *outcome->decision.chosen;
    if (*chosen[w] < possible.size() && *chosen[w] < (*observation)->analysis().candidates.size()) continue;
    chosen[w] = grasps.size();
    grasps.push_back(outcome->candidates[*outcome->decision.chosen]);
    possible.push_back(true);
  }
  std::vector<std::size_t> always;
  for (const auto& c : chosen)
    if (c) always.push_back(*c);
  if (always.empty()) return refused(why);
  const auto tried = spread_over(grasps, possible, always, kGrasps);

  control::Config config = config_for(trial.method, task());
  TrialRows rows;
  std::vector<double> share(grasps.size(), NAN);
  const hal::Vec3 partner = (*observation)->true_partner();
  int lifted = 0;
  for (std::size_t k = 0; k < tried.size(); ++k) {
    const std::size_t i = tried[k];
    const DirectLift lift = try_grasp(**observation, scenario, grasps[i], config, seed);
    if (lift.lifted) share[i] = lift.share_robot, ++lifted;
    Row d{letter(k),          cell(grasps[i].id), cell((grasps[i].position - partner).head<2>().norm()),
          cell(lift.lifted),  cell(lift.robot_n), cell(lift.share_robot),
          cell(lift.tilt_deg)};
    for (const auto& c : chosen) d.push_back(cell(c && *c == i));
    d.push_back(lift.reason);
    rows.details.push_back(std::move(d));
  }
  rows.row = {scenario.name, cell(scenario.object.mass), cell(static_cast<int>(tried.size())), cell(lifted)};
  rows.words = scenario.name + ":";
  for (std::size_t w = 0; w < kWanted.size(); ++w) {
    double best = NAN;
    for (const std::size_t i : tried)
      if (!(std::abs(share[i] - kWanted[w]) >= best)) {
        const double e = std::abs(share[i] - kWanted[w]);
        if (!std::isnan(e)) best = e;
      }
    const double measured = chosen[w] ? share[*chosen[w]] : NAN;
    const double error = std::abs(measured - kWanted[w]);
    rows.row.push_back(cell(!forbidden[w]));
    for (const double v : {predicted[w], measured, error, best}) rows.row.push_back(cell(v));
    rows.row.push_back(std::isnan(error) ? "" : cell(error <= best));
    rows.row.push_back(std::isnan(error) ? "" : cell(error <= best + kNear));
    rows.words += forbidden[w]           ? fmt::format(" {:.2f} not asked: {}.", kWanted[w], *forbidden[w])
                  : std::isnan(measured) ? fmt::format(" {:.2f} not lifted.", kWanted[w])
                                         : fmt::format(" {:.2f} wanted {:.2f} borne.", kWanted[w], measured);
  }
  rows.row.push_back(why);
  return rows;
}

std::vector<Figure> figures(const Results& r) {
  std::vector<Figure> out;
  std::vector<double> all_errors;
  int all_near = 0, all_within = 0, all = 0, all_asked = 0;
  for (std::size_t w = 0; w < kWanted.size(); ++w) {
    const std::string at = kName[w];
    std::vector<double> measured, predicted;
    int best = 0, near = 0, within = 0, n = 0, asked = 0;
    for (const Row& row : r.trials.rows()) {
      asked += r.trials.number(row, "asked_" + at) > 0.5;
      const double error = r.trials.number(row, "error_" + at);
      if (std::isnan(error)) continue;
      ++n;
      measured.push_back(r.trials.number(row, "measured_" + at));
      predicted.push_back(r.trials.number(row, "predicted_" + at));
      best += r.trials.number(row, "best_" + at) > 0.5;
      near += r.trials.number(row, "near_best_" + at) > 0.5;
      within += error <= kShareError;
      all_errors.push_back(error);
    }
    all += n;
    all_asked += asked;
    all_near += near;
    all_within += within;
    out.push_back({"lifted_" + at, fmt::format("{} %: chosen grasp lifted, of those asked for", at),
                   rate(n, asked), "%"});
    out.push_back({"predicted_" + at, fmt::format("share predicted where {} % were wanted, median", at),
                   quantile_estimate(predicted, 0.5), "%"});
    out.push_back({"measured_" + at, fmt::format("share measured where {} % were wanted, median", at),
                   quantile_estimate(measured, 0.5), "%"});
    out.push_back({"best_" + at,
                   fmt::format("{} %: chosen grasp is the best of those tried", at),
                   rate(best, n),
                   "%",
                   {},
                   true,
                   w == 1 ? "no: next to the best" : ""});
    out.push_back({"within_" + at, fmt::format("{} %: error of the share within 0.05", at), rate(within, n),
                   "%", 0.95, true});
  }
  out.push_back({"best_or_near", "chosen is the best or within 0.02 of it, all shares", rate(all_near, all),
                 "%", 0.95, true, "next to the best"});
  out.push_back({"share_error_p95", "error of the share, 95 % below", quantile_estimate(all_errors, 0.95), "",
                 kShareError, false});
  out.push_back({"within_all", "error within 0.05, all shares", rate(all_within, all), "%", 0.95, true});
  out.push_back({"lifted", "chosen grasps lifted, of all shares asked for", rate(all, all_asked), "%"});
  return out;
}

picture::Canvas plot(const Results& r) {
  std::vector<BarPanel> panels;
  for (const Row& row : r.trials.rows()) {
    if (panels.size() == 4) break;
    const int trial = TrialTable::trial_of(row);
    const double weight = hal::kGravity_m_s2 * r.trials.number(row, "mass_kg");
    BarPanel panel;
    panel.title = fmt::format("{}: force of the robot (N), half wanted", r.trials.text(row, "layout"));
    for (const Row& d : r.details.rows())
      if (TrialTable::trial_of(d) == trial)
        panel.bars.push_back({r.details.text(d, "grasp"), r.details.number(d, "robot_n"),
                              r.details.number(d, "chosen_50") > 0.5});
    if (panel.bars.empty()) continue;
    panel.levels.push_back({"half of the load", 0.5 * weight, picture::kCog});
    panels.push_back(std::move(panel));
  }
  return draw_bar_plot(panels);
}

}  // namespace
}  // namespace load_trials

Experiment load_experiment() {
  using namespace load_trials;
  Experiment e;
  e.name = "load";
  e.title = "Load distribution";
  e.thesis = "6.3.3, figure 6.12";
  e.question =
      "A long box with all grasps in line with the partner and the centre of gravity. The robot's vertical "
      "force is measured for up to seven grasps, among them the ones chosen for 30, 50 and 67 % of the load, "
      "where the lever rule, the arm's reach and room for both hands permit these on that box.";
  e.default_trials = 100;
  e.columns = {"layout", "mass_kg", "tried", "lifted"};
  for (const char* w : kName)
    for (const char* what :
         {"asked_", "predicted_", "measured_", "error_", "best_error_", "best_", "near_best_"})
      e.columns.push_back(std::string(what) + w);
  e.columns.push_back("because");
  e.detail_columns = {"grasp",    "id",        "from_partner_m", "lifted",    "robot_n", "share_robot",
                      "tilt_deg", "chosen_30", "chosen_50",      "chosen_67", "because"};
  e.run = run;
  e.task = task();
  e.trials_set = "decision.share";
  e.figures = figures;
  e.plot = plot;
  return e;
}

}  // namespace colift::experiments
