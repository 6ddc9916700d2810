// Beyond the thesis: the impedance of the arm while it carries, of its joints or of the palm.

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "sim_hal/scenario/object_parts.hpp"
#include "sim_hal/synthetic/hash_random.hpp"
#include "tools/experiments/bar_plot.hpp"
#include "tools/experiments/experiment.hpp"
#include "tools/experiments/runs/whole_lift.hpp"
#include "tools/experiments/trials/layouts.hpp"

namespace colift::experiments {
namespace impedance_trials {
namespace {

constexpr double kMuch_mm = 5.0;  // of motion when the hand opens: the scenario is kept
constexpr std::array<const char*, 2> kControls{"joint_impedance", "cartesian_impedance"};
constexpr std::array<const char*, 2> kShort{"joint", "palm"};
constexpr std::array<const char*, 3> kPartners{"still", "sways", "turns"};
constexpr double kHeight_m = 0.05, kHold_s = 2.0;
constexpr int kDrawn = 8;         // trials before it have shipped scenes
constexpr int kEvery_ms = 5;      // of the samples
constexpr double kAfter_s = 0.3;  // the object may still move after the hand has left it
constexpr double kOffGround_n = 1.0;

control::TaskSaid task() {
  return {"experiment impedance", kHeight_m, kHold_s};
}

/// His hand stands still, sways sideways while the object goes up, or goes round as one who turns on his
/// heel.
sim_hal::Scenario layout(const Trial& trial) {
  sim_hal::Scenario s = mixed_layout(trial.index + kDrawn, trial.seed);
  s.task.height = kHeight_m;
  s.task.hold_s = kHold_s;
  sim_hal::Draws draws(trial.own_seed(31), 9100);
  const std::size_t partner = static_cast<std::size_t>(trial.index / 4) % kPartners.size();
  if (partner > 0) {
    sim_hal::PartnerScriptEvent sway{draws.between(0.2, 0.8), "sway", std::nullopt};
    sway.in_state = partner == 1 ? "lift" : "hold";
    sway.by_m = draws.between(0.015, 0.03);
    sway.for_s = draws.between(1.2, 2.0);
    const double a = draws.between(-std::numbers::pi, std::numbers::pi);
    sway.direction = hal::Vec3(std::cos(a), std::sin(a), 0.0);
    if (partner == 2) {  // across the line of both hands: the object turns about the robot's
      const hal::Vec3 line = sim_hal::object_pose(s.object) * s.partner.grasp;
      sway.direction = (a < 0.0 ? -1.0 : 1.0) * hal::Vec3(-line.y(), line.x(), 0.0).normalized();
    }
    s.partner.events.push_back(sway);
  }
  return seen_from(trial.view, s);
}

struct Sample {
  double t_s = 0.0, side_n = 0.0;
  bool in_air = false;
  hal::Pose X_WT = hal::Pose::Identity();
};

/// What one lift did to the partner and to the object.
struct Measured {
  std::string outcome = "error", because;
  double side_n = NAN, side_peak_n = NAN;  ///< His horizontal force while it is in the air: 95 %, peak.
  double release_mm = NAN;                 ///< How far the object jumps when the hand opens.
  double tilt_deg = NAN, share_error = NAN, slip_mm = NAN, margin_j = NAN;
};

std::optional<double> begin_of(const control::RunRecord& record, control::Task state) {
  for (const control::StateChange& change : record.states)
    if (change.state == state) return hal::seconds(change.at);
  return std::nullopt;
}

Measured lift(const sim_hal::Scenario& scenario, const Trial& trial, const char* control) {
  std::vector<Sample> samples;
  int tick = 0;
  LiftHooks hooks;
  hooks.settings = {{"task.lift.control", control}};
  hooks.each_tick = [&](const sim_hal::TickReport& report) {
    if (tick++ % kEvery_ms != 0) return;
    const sim_hal::SimTruth& t = report.truth;
    const bool in_air = t.floor_force_W.z() < kOffGround_n && t.robot_force_W.z() > kOffGround_n;
    samples.push_back({report.t_s, t.partner_force_W.head<2>().norm(), in_air, t.X_WT});
  };
  Measured m;
  const auto done = run_whole_lift(scenario, trial.method, trial.own_seed(32), hooks);
  if (!done) {
    m.because = done.error().text();
    return m;
  }
  m.outcome = word(done->record.outcome);
  m.because = done->record.reason;
  if (done->record.outcome != control::RunRecord::Result::Lifted || !done->record.lift) return m;
  std::vector<double> side_n;
  for (const Sample& s : samples)
    if (s.in_air) side_n.push_back(s.side_n);
  m.side_n = quantile(side_n, 0.95);
  m.side_peak_n = quantile(side_n, 1.0);
  const auto release_s = begin_of(done->record, control::Task::Release);
  const auto retreat_s = begin_of(done->record, control::Task::Retreat);
  if (release_s && retreat_s) {
    std::optional<hal::Pose> X_WT0;
    double most_m = 0.0;
    for (const Sample& s : samples) {
      if (s.t_s < *release_s || s.t_s > *retreat_s + kAfter_s) continue;
      if (!X_WT0) X_WT0 = s.X_WT;
      // where the partner holds it: what he feels
      most_m = std::max(most_m, (s.X_WT * scenario.partner.grasp - *X_WT0 * scenario.partner.grasp).norm());
    }
    m.release_mm = 1e3 * most_m;
  }
  m.tilt_deg = done->tilt_deg;
  m.share_error = std::abs(done->share_robot - done->record.lift->share_predicted);
  m.slip_mm = 1e3 * done->slip_m;
  m.margin_j = done->record.energy_margin_j;
  return m;
}

TrialRows run(const Trial& trial) {
  const sim_hal::Scenario scenario = layout(trial);
  const std::string partner = kPartners[static_cast<std::size_t>(trial.index / 4) % kPartners.size()];
  TrialRows rows;
  rows.row = {scenario.name, partner, cell(scenario.object.mass)};
  rows.words = scenario.name + ", who holds it " + partner + ": ";
  std::string why;
  for (std::size_t i = 0; i < kControls.size(); ++i) {
    const Measured m = lift(scenario, trial, kControls[i]);
    rows.row.push_back(m.outcome);
    for (const double v :
         {m.side_n, m.side_peak_n, m.release_mm, m.tilt_deg, m.share_error, m.slip_mm, m.margin_j})
      rows.row.push_back(cell(v));
    rows.words += fmt::format("{}{} {}, {:.0f} N sideways", i ? "; " : "", kShort[i], m.outcome, m.side_n);
    if (m.outcome != "lifted" || m.release_mm > kMuch_mm) rows.kept = KeptLift{scenario, trial.own_seed(32)};
    if (m.outcome != "lifted") why += fmt::format("{}: {} ", kShort[i], m.because);
  }
  rows.row.push_back(why);
  return rows;
}

std::vector<double> where(const Results& r, const std::string& column, const std::string& partner = "") {
  std::vector<double> out;
  for (const Row& row : r.trials.rows()) {
    if (!partner.empty() && r.trials.text(row, "partner") != partner) continue;
    // pairs only: what one control could not lift would flatter it
    if (r.trials.text(row, "joint_outcome") != "lifted" || r.trials.text(row, "palm_outcome") != "lifted")
      continue;
    const double v = r.trials.number(row, column);
    if (!std::isnan(v)) out.push_back(v);
  }
  return out;
}

std::vector<Figure> figures(const Results& r) {
  std::vector<Figure> out;
  for (const std::string control : {"joint", "palm"}) {
    int all = 0, lifted = 0;
    for (const Row& row : r.trials.rows()) {
      ++all;
      lifted += r.trials.text(row, control + "_outcome") == "lifted";
    }
    out.push_back({control + "_lifted", control + ": lifted", rate(lifted, all), "%"});
  }
  for (const char* partner : kPartners)
    for (const std::string control : {"joint", "palm"})
      out.push_back({fmt::format("{}_side_{}", control, partner),
                     fmt::format("{}: force on a partner who {}, sideways, 95 % of the time below; median",
                                 control, std::string(partner) == "still" ? "holds still" : partner),
                     quantile_estimate(where(r, control + "_side_n", partner), 0.5), "N"});
  struct What {
    const char *column, *name;
    double part;
    const char* unit;
  };
  for (const What& w :
       {What{"release_mm", "motion of the partner's end while the hand opens, median", 0.5, "mm"},
        What{"release_mm", "motion of the partner's end while the hand opens, 95 % below", 0.95, "mm"},
        What{"tilt_deg", "tilt at the top, 95 % below", 0.95, "deg"},
        What{"share_error", "share against the predicted one, 95 % below", 0.95, ""},
        What{"slip_mm", "slip in the hand, 95 % below", 0.95, "mm"},
        What{"margin_j", "least passivity margin", 0.0, "J"}})
    for (const std::string control : {"joint", "palm"})
      out.push_back({fmt::format("{}_{}{}", control, w.column, w.part == 0.5 ? "_median" : ""),
                     control + ": " + w.name, quantile_estimate(where(r, control + "_" + w.column), w.part),
                     w.unit});
  for (Figure& f : out)
    if (f.key.ends_with("margin_j")) f.goal = 0.0, f.at_least = true;
  return out;
}

picture::Canvas plot(const Results& r) {
  std::vector<BarPanel> panels;
  for (const char* what : {"side_n", "release_mm"})
    for (const char* partner : kPartners) {
      BarPanel panel;
      panel.title = std::string(what) == "side_n"
                        ? fmt::format("N sideways on the partner ({}): median, quartiles", partner)
                        : fmt::format("mm at release ({}): median, quartiles", partner);
      for (const char* control : kShort) {
        const std::vector<double> v = where(r, fmt::format("{}_{}", control, what), partner);
        if (!v.empty())
          panel.bars.push_back({control, quantile(v, 0.5), false, quantile(v, 0.25), quantile(v, 0.75)});
      }
      if (!panel.bars.empty()) panels.push_back(std::move(panel));
    }
  return draw_bar_plot(panels);
}

}  // namespace
}  // namespace impedance_trials

Experiment impedance_experiment() {
  using namespace impedance_trials;
  Experiment e;
  e.name = "impedance";
  e.title = "Impedance of the joints or of the palm";
  e.thesis = "beyond";
  e.question =
      "The same lift of tables, boxes, pipes and chairs with the arm's joints as springs, and with springs "
      "of the palm (stiff along gravity and in tilt, soft sideways); the partner's hand holds still, sways "
      "by 15 to 30 mm while the object goes up, or goes across at the top.";
  e.default_trials = 60;
  e.columns = {"layout", "partner", "mass_kg"};
  for (const std::string control : kShort)
    for (const char* column :
         {"outcome", "side_n", "side_peak_n", "release_mm", "tilt_deg", "share_error", "slip_mm", "margin_j"})
      e.columns.push_back(control + "_" + column);
  e.columns.push_back("because");
  e.run = run;
  e.task = task();
  e.trials_set = "task.lift.control";
  e.figures = figures;
  e.plot = plot;
  return e;
}

}  // namespace colift::experiments
