// Beyond the thesis: what a lift of a few millimetres tells.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "hal/types/units.hpp"
#include "sim_hal/synthetic/hash_random.hpp"
#include "tools/experiments/bar_plot.hpp"
#include "tools/experiments/experiment.hpp"
#include "tools/experiments/trials/layouts.hpp"
#include "tools/experiments/trials/test_lifts.hpp"
#include "tools/visualization/palette.hpp"

namespace colift::experiments {
namespace wrong_cog_trials {
namespace {

constexpr double kMin_m = 0.10, kMost_m = 0.20;
constexpr double kHeight_m = 0.05, kHold_s = 1.0, kBudget_deg = 2.0;

control::TaskSaid task() {
  return {"experiment wrong-cog", kHeight_m, kHold_s};
}
constexpr double kCarefully_s = 10.0;  // a grip that was only tried slowly is lifted slowly
constexpr std::size_t kColumns = 15, kDetailColumns = 22;

const char* word(control::TestLift::Next next) {
  using Next = control::TestLift::Next;
  return next == Next::GoOn ? "go on" : next == Next::OtherShare ? "other share" : "re-grasp";
}

TrialRows run(const Trial& trial) {
  const std::uint64_t seed = trial.own_seed(6);
  sim_hal::Scenario scenario = table_layout(trial.index + 2, trial.seed);
  sim_hal::Draws draws(seed, 7600);
  const double off = draws.between(kMin_m, kMost_m), a = 2.0 * std::numbers::pi * draws.between(0.0, 1.0);
  scenario.object.cog_offset = {off * std::cos(a), off * std::sin(a), 0.0};
  const auto refused = [&](const std::string& why) {
    Row row{scenario.name, cell(scenario.object.mass), cell(1e3 * off)};
    row.resize(kColumns - 1);
    row.push_back(why);
    return TrialRows{row, {}, scenario.name + ": " + why};
  };
  auto observation = Observation::make(scenario, trial.method, seed, kHeight_m);
  if (!observation) return refused(observation.error().text());
  const control::Config config = config_for(trial.method, task());
  const auto outcome = (*observation)->decide(config);
  if (!outcome) return refused(outcome.error().text());
  if (!outcome->decision.chosen) return refused(outcome->decision.reason);
  const planner::GraspCandidate& first = outcome->candidates[*outcome->decision.chosen];
  const DirectLift blind = try_grasp(**observation, scenario, first, config, seed);

  const GripSearch search = search_level_grip(**observation, scenario, *outcome, trial.method, config, seed);
  const TriedGrip& last = search.tried.back();
  DirectLift lift;
  if (search.level) {
    const control::Config careful =
        config_for(trial.method, task(), {{"task.lift_s", fmt::format("{}", kCarefully_s)}});
    Observation& now = search.elsewhere ? *search.elsewhere : **observation;
    lift = try_grasp(now, search.scenario, search.tried[*search.level].grasp, careful, seed);
  }

  const hal::Vec3 true_cog = (*observation)->true_cog();
  TrialRows rows;
  double worst_test = 0.0;
  std::string words;
  for (std::size_t k = 0; k < search.tried.size(); ++k) {
    const TriedGrip& t = search.tried[k];
    worst_test = std::max(worst_test, t.lift.most_tilt_deg);
    Row row{letter(k),
            cell(t.asked),
            cell(t.partner.x()),
            cell(t.partner.y()),
            cell(t.grasp.id),
            cell(t.grasp.position.x()),
            cell(t.grasp.position.y()),
            cell(t.chance),
            cell(1e3 * t.lift.height_m),
            cell(t.lift.tilt_deg),
            cell(t.lift.most_tilt_deg)};
    if (t.known) {
      const auto& known = *t.known;
      row.insert(row.end(),
                 {cell(hal::rad_to_deg(known.seen.tilt_rad)), cell(hal::rad_to_deg(known.seen.turn_rad)),
                  cell(1e3 * known.seen.min_rise_m), cell(known.stands), cell(known.mass_kg),
                  cell(1e3 * (known.cog - true_cog).head<2>().norm()), cell(1e3 * known.lever_m),
                  cell(known.belief.grip_nm_rad), cell(hal::rad_to_deg(t.drift_rad_s)), word(known.next)});
    }
    row.resize(kDetailColumns - 1);
    row.push_back(t.reason);
    rows.details.push_back(std::move(row));
  }
  rows.row = {scenario.name,
              cell(scenario.object.mass),
              cell(1e3 * off),
              cell(blind.lifted ? blind.tilt_deg : NAN),
              cell(static_cast<int>(search.tried.size())),
              cell(static_cast<int>(search.asked.size())),
              last.known ? word(last.known->next) : "nothing",
              cell(last.known ? last.known->mass_kg : NAN),
              cell(last.known ? 1e3 * (last.known->cog - true_cog).head<2>().norm() : NAN),
              cell(last.known ? last.known->share : NAN),
              cell(worst_test),
              cell(search.level.has_value()),
              cell(lift.lifted ? lift.share_robot : NAN),
              cell(lift.lifted ? lift.tilt_deg : NAN),
              search.level && !lift.lifted ? lift.reason : search.reason};
  rows.words = fmt::format("{}: {:.0f} mm off: tilt {:.2f} deg; {} grips, asked {} times, {}: {:.2f} deg",
                           scenario.name, 1e3 * off, blind.tilt_deg, search.tried.size(), search.asked.size(),
                           search.level ? "lifted" : "refused", lift.tilt_deg);
  return rows;
}

std::vector<Figure> figures(const Results& r) {
  std::vector<double> before, after, mass, cog, tests, grips;
  int n = 0, broke = 0, recovered = 0, alone = 0, asked = 0, refused = 0, spoilt = 0, wrong = 0, lifted = 0;
  for (const Row& row : r.trials.rows()) {
    if (r.trials.text(row, "next").empty()) continue;
    ++n;
    const double b = r.trials.number(row, "tilt_before_deg"), t = r.trials.number(row, "tilt_after_deg");
    const bool level = r.trials.number(row, "level") > 0.5;
    const bool bad = !(b <= kBudget_deg), good = t <= kBudget_deg;
    broke += bad;
    const bool was_asked = r.trials.number(row, "asked") > 0.5;
    recovered += bad && good;
    alone += bad && good && !was_asked;
    asked += bad && was_asked;
    refused += bad && !level;
    spoilt += !bad && !good;
    lifted += level;
    wrong += level && !good;
    before.push_back(b);
    if (level) after.push_back(t);
    if (bad) grips.push_back(r.trials.number(row, "grips"));
    tests.push_back(r.trials.number(row, "test_tilt_deg"));
    const double m = r.trials.number(row, "mass_kg");
    mass.push_back(std::abs(r.trials.number(row, "mass_measured_kg") - m) / m);
    cog.push_back(r.trials.number(row, "cog_error_mm"));
  }
  return {
      {"broke_budget", "lifts that would tilt by more than 2 deg", rate(broke, n), "%"},
      {"recovered", "... of them below 2 deg after test lifts", rate(recovered, broke), "%", 0.90, true},
      {"recovered_alone", "... of them without asking the partner", rate(alone, broke), "%"},
      {"asked", "... of them for which the partner was asked to grasp elsewhere", rate(asked, broke), "%"},
      {"recovered_asked", "... and then below 2 deg", rate(recovered - alone, asked), "%"},
      {"refused", "... of them not lifted: no level grip was found", rate(refused, broke), "%"},
      {"wrong", "lifts over 2 deg among those that the test lifts let pass", rate(wrong, lifted), "%"},
      {"spoilt", "lifts below 2 deg that test lifts made worse or refused", rate(spoilt, n - broke), "%"},
      {"grips_mean", "grips tried where the first would break the budget, mean", mean_estimate(grips), ""},
      {"test_tilt_p95", "tilt during a test lift, 95 % below", quantile_estimate(tests, 0.95), "deg"},
      {"tilt_p95_before", "tilt without test lifts, 95 % below", quantile_estimate(before, 0.95), "deg"},
      {"tilt_p95_after", "tilt with them, 95 % below", quantile_estimate(after, 0.95), "deg"},
      {"mass_error_median", "relative error of the mass, median", quantile_estimate(mass, 0.5), "%"},
      {"cog_error_median", "error of the corrected centre of gravity, median", quantile_estimate(cog, 0.5),
       "mm"}};
}

picture::Canvas plot(const Results& r) {
  std::vector<BarPanel> panels;
  for (const char* column : {"tilt_before_deg", "tilt_after_deg"}) {
    BarPanel panel{fmt::format("{} a test lift: tilt (deg)",
                               std::string(column) == "tilt_before_deg" ? "Without" : "With"),
                   {},
                   {{"budget", kBudget_deg, picture::kCog}},
                   8.0};
    for (const Row& row : r.trials.rows()) {
      if (panel.bars.size() == 16) break;
      panel.bars.push_back({letter(panel.bars.size()), r.trials.number(row, column), false});
    }
    panels.push_back(std::move(panel));
  }
  return draw_bar_plot(panels);
}

}  // namespace
}  // namespace wrong_cog_trials

Experiment wrong_cog_experiment() {
  using namespace wrong_cog_trials;
  Experiment e;
  e.name = "wrong-cog";
  e.title = "Uneven density and a test lift";
  e.thesis = "beyond it";
  e.question =
      "A table whose centre of gravity lies 10 to 20 cm off its shape's, in any direction. Lifted at once, "
      "and after test lifts: slow, at most 30 mm, ended as soon as the camera sees the table turn or hang "
      "free. What arm and camera say of mass and centre of gravity decides: lift on, or put down and take "
      "hold elsewhere, up to four times; "
      "then the partner is asked to grasp elsewhere, up to twice, and all is seen anew.";
  e.default_trials = 100;
  e.columns = {"layout",        "mass_kg", "cog_off_mm",       "tilt_before_deg", "grips",
               "asked",         "next",    "mass_measured_kg", "cog_error_mm",    "share_measured",
               "test_tilt_deg", "level",   "share_robot",      "tilt_after_deg",  "because"};
  e.detail_columns = {"grip",
                      "asked",
                      "partner_x_m",
                      "partner_y_m",
                      "id",
                      "x_m",
                      "y_m",
                      "chance",
                      "height_mm",
                      "tilt_deg",
                      "most_tilt_deg",
                      "seen_deg",
                      "seen_turn_deg",
                      "least_rise_mm",
                      "stands",
                      "mass_measured_kg",
                      "cog_error_mm",
                      "lever_mm",
                      "grip_nm_rad",
                      "drift_deg_s",
                      "next",
                      "because"};
  e.run = run;
  e.task = task();
  e.trials_set =
      "task.lift_s; for test lifts task.lift_height_m, lift_s, hold_s, slow_fraction and "
      "decision.max_lever_m";
  e.figures = figures;
  e.plot = plot;
  return e;
}

}  // namespace colift::experiments
