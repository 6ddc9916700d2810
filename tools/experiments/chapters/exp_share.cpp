// Beyond the thesis: is what is said about the share of the load true?

#include <fmt/format.h>

#include <array>
#include <cmath>

#include "sim_hal/scenario/object_parts.hpp"
#include "sim_hal/synthetic/hash_random.hpp"
#include "tools/experiments/bar_plot.hpp"
#include "tools/experiments/experiment.hpp"
#include "tools/experiments/runs/whole_lift.hpp"
#include "tools/experiments/trials/layouts.hpp"
#include "tools/visualization/palette.hpp"

namespace colift::experiments {
namespace share_trials {
namespace {

constexpr std::array<double, 5> kWanted{0.30, 0.40, 0.50, 0.60, 0.70};
constexpr std::array<const char*, 4> kKinds{"table", "box", "pipe", "chair"};  // as mixed_layout takes them
constexpr int kDrawn = 8;  // trials before it have shipped scenes
constexpr double kHeight_m = 0.05, kHold_s = 1.0;
constexpr double kMeasured = 0.03, kPredicted = 0.05;  // errors of the share that are asked for

control::TaskSaid task() {
  return {"experiment share", kHeight_m, kHold_s};
}

sim_hal::Scenario layout(const Trial& trial) {
  sim_hal::Scenario s = mixed_layout(trial.index + kDrawn, trial.seed);
  s.task.height = kHeight_m;
  s.task.hold_s = kHold_s;
  if (s.object.kind == "cylinder") {  // elsewhere the layouts put him at the end
    sim_hal::Draws draws(trial.own_seed(13), 8300);
    s.partner.grasp.x() = draws.between(0.25, 0.42) * s.object.size[1];
  }
  return seen_from(trial.view, s);
}

hal::Result<WholeLift> lift(const sim_hal::Scenario& scenario, const Trial& trial, double wanted) {
  LiftHooks hooks;
  hooks.ended = trial.watch;
  hooks.settings = {{"decision.share", fmt::format("{}", wanted)}};
  return run_whole_lift(scenario, trial.method, trial.own_seed(12), hooks);
}

double cog_error_m(const control::RunRecord& record, const sim_hal::Scenario& scenario) {
  if (!record.analysis || !record.analysis->scene.target) return NAN;
  const auto parts = sim_hal::object_parts(scenario.object);
  if (!parts) return NAN;
  const hal::Vec3 truth = sim_hal::object_pose(scenario.object) * parts->cog_T;
  return (record.analysis->scene.target->cog - truth).head<2>().norm();
}

double partner_error_m(const control::RunRecord& record, const sim_hal::Scenario& scenario) {
  if (!record.decision || !record.decision->partner) return NAN;
  return (record.decision->partner->position - sim_hal::object_pose(scenario.object) * scenario.partner.grasp)
      .norm();
}

// What the lever rule says with the true centre of gravity and partner: how far a wrong prediction is
// perception's, and how far the rule's.
double true_lever(const control::RunRecord& record, const sim_hal::Scenario& scenario) {
  const auto parts = sim_hal::object_parts(scenario.object);
  if (!parts || !record.decision || !record.decision->decision.chosen) return NAN;
  const hal::Pose X_WT = sim_hal::object_pose(scenario.object);
  const planner::GraspCandidate& c = record.decision->candidates[*record.decision->decision.chosen];
  return planner::lever_share(X_WT * parts->cog_T, X_WT * scenario.partner.grasp, planner::load_point(c),
                              hal::Vec3::UnitZ())
      .value_or(NAN);
}

TrialRows run(const Trial& trial) {
  const auto n = static_cast<std::size_t>(trial.index);
  const std::string kind = kKinds[n % kKinds.size()];
  const double wanted = kWanted[n / kKinds.size() % kWanted.size()];
  const sim_hal::Scenario scenario = layout(trial);
  const auto done = lift(scenario, trial, wanted);
  const auto row = [&](const control::ShareContract* s, const WholeLift* l, const WholeLift* elsewhere,
                       const std::string& outcome, const std::string& why, const std::string& not_there) {
    const auto low = [](const auto& r) { return r ? r->low : NAN; };
    const auto high = [](const auto& r) { return r ? r->high : NAN; };
    Row out{scenario.name, kind, cell(scenario.object.mass), cell(wanted), outcome};
    const control::ShareContract none;
    const control::ShareContract& c = s ? *s : none;
    for (const double v :
         {low(c.reachable), high(c.reachable), c.predicted.value_or(NAN), low(c.interval), high(c.interval)})
      out.push_back(cell(v));
    out.push_back(c.as_wished ? cell(*c.as_wished) : "");
    out.push_back(cell(c.interval ? c.tolerance : NAN));
    const bool lifted = l && l->record.outcome == control::RunRecord::Result::Lifted && l->record.lift;
    out.push_back(cell(lifted ? l->record.lift->share_robot : NAN));
    out.push_back(cell(lifted ? l->share_robot : NAN));
    out.push_back(cell(l ? 1e3 * cog_error_m(l->record, scenario) : NAN));
    out.push_back(cell(lifted ? l->tilt_deg : NAN));
    out.push_back(cell(c.elsewhere.has_value()));
    const bool there = elsewhere && elsewhere->record.outcome == control::RunRecord::Result::Lifted;
    out.push_back(elsewhere && elsewhere->record.decision
                      ? cell(elsewhere->record.decision->share.predicted.value_or(NAN))
                      : "");
    out.push_back(cell(there ? elsewhere->share_robot : NAN));
    out.push_back(elsewhere ? elsewhere->record.reason : not_there);
    const auto sigma = [](const Eigen::Matrix3d& m) {
      return 1e3 * std::sqrt(m.topLeftCorner<2, 2>().trace());
    };
    const bool target = l && l->record.analysis && l->record.analysis->scene.target;
    out.push_back(cell(target ? sigma(l->record.analysis->scene.target->cog_covariance) : NAN));
    const bool partner = l && l->record.decision && l->record.decision->partner;
    out.push_back(cell(partner ? sigma(l->record.decision->partner->covariance) : NAN));
    out.push_back(cell(l ? 1e3 * partner_error_m(l->record, scenario) : NAN));
    out.push_back(cell(l ? true_lever(l->record, scenario) : NAN));
    out.push_back(why);
    return out;
  };
  if (!done) {
    const std::string why = done.error().text();
    return {row(nullptr, nullptr, nullptr, "error", why, ""), {}, scenario.name + ": " + why};
  }
  const control::RunRecord& record = done->record;
  const control::ShareContract* share = record.decision ? &record.decision->share : nullptr;
  std::optional<WholeLift> elsewhere;
  std::string not_there;
  if (share && share->elsewhere) {
    // the place that was named, tried
    sim_hal::Scenario moved = scenario;
    moved.partner.grasp = sim_hal::object_pose(scenario.object).inverse() * share->elsewhere->partner;
    auto there = lift(moved, trial, wanted);
    if (there)
      elsewhere = std::move(*there);
    else
      not_there = there.error().text();
  }
  TrialRows rows;
  rows.row =
      row(share, &*done, elsewhere ? &*elsewhere : nullptr, word(record.outcome), record.reason, not_there);
  rows.words = fmt::format("{}, {}: {:.0f} % wanted; {}", scenario.name, word(record.outcome), 100 * wanted,
                           share ? share->text : record.reason);
  return rows;
}

std::vector<double> where(const Results& r, const std::string& column, const std::string& kind,
                          std::optional<double> wanted) {
  std::vector<double> out;
  for (const Row& row : r.trials.rows()) {
    if (!kind.empty() && r.trials.text(row, "kind") != kind) continue;
    if (wanted && std::abs(r.trials.number(row, "wanted") - *wanted) > 1e-6) continue;
    const double v = r.trials.number(row, column);
    if (!std::isnan(v)) out.push_back(v);
  }
  return out;
}

std::vector<Figure> figures(const Results& r) {
  int all = 0, lifted = 0, measured = 0, predicted = 0, covered = 0, with_interval = 0;
  int claims = 0, claims_true = 0, reached = 0, could = 0, told = 0, told_lifted = 0, told_true = 0,
      missed = 0;
  std::array<int, kKinds.size()> of_kind{}, right_of_kind{};
  std::vector<double> half_width;
  for (const Row& row : r.trials.rows()) {
    const auto at = [&](const char* column) { return r.trials.number(row, column); };
    ++all;
    const double truth = at("true"), wanted = at("wanted");
    const bool reachable = at("reach_low") - 0.02 <= wanted && wanted <= at("reach_high") + 0.02;
    missed += !std::isnan(at("reach_low")) && !reachable;
    if (at("elsewhere") > 0.5) {
      ++told;
      const double there = at("elsewhere_true");
      told_lifted += !std::isnan(there);
      told_true += std::abs(there - wanted) <= kPredicted;
    }
    if (std::isnan(truth)) continue;
    ++lifted;
    measured += std::abs(at("measured") - truth) <= kMeasured;
    const bool right = std::abs(at("predicted") - truth) <= kPredicted;
    predicted += right;
    for (std::size_t k = 0; k < kKinds.size(); ++k)
      if (r.trials.text(row, "kind") == kKinds[k]) ++of_kind[k], right_of_kind[k] += right;
    if (!std::isnan(at("interval_low"))) {
      ++with_interval;
      covered += at("interval_low") <= truth && truth <= at("interval_high");
      half_width.push_back(0.5 * (at("interval_high") - at("interval_low")));
    }
    if (at("as_wished") > 0.5) {
      ++claims;
      claims_true += std::abs(truth - wanted) <= at("tolerance");
    }
    if (reachable) ++could, reached += std::abs(truth - wanted) <= kPredicted;
  }
  std::vector<Figure> out{
      {"lifted", "jobs that lifted", rate(lifted, all), "%"},
      {"measured_right", "measured share within 0.03 of the true one", rate(measured, lifted), "%", 0.95,
       true},
      {"predicted_right", "predicted share within 0.05 of the true one", rate(predicted, lifted), "%", 0.95,
       true},
      {"covered", "true share in the prediction's 95 % interval", rate(covered, with_interval), "%", 0.93,
       true},
      {"half_width", "half width of that interval, median", quantile_estimate(half_width, 0.5), ""},
      {"claims", "share said to be as wished", rate(claims, lifted), "%"},
      {"claims_true", "such claims that were true to the tolerance said", rate(claims_true, claims), "%",
       0.95, true},
      {"not_reachable", "wanted share said to be out of reach", rate(missed, all), "%"},
      {"reached", "true share within 0.05 of the wanted one, where it was said to be reachable",
       rate(reached, could), "%"},
      {"told", "another place of the partner named where not reachable", rate(told, missed), "%"},
      {"told_lifted", "partner at that place: lifted", rate(told_lifted, told), "%"},
      {"told_true", "partner at that place: true share within 0.05 of the wanted one",
       rate(told_true, told_lifted), "%"}};
  for (std::size_t k = 0; k < kKinds.size(); ++k)
    out.push_back({fmt::format("predicted_right_{}", kKinds[k]),
                   fmt::format("{}: predicted within 0.05 of the true one", kKinds[k]),
                   rate(right_of_kind[k], of_kind[k]), "%"});
  for (const double w : kWanted)
    for (const char* what : {"predicted", "measured", "true"})
      out.push_back({fmt::format("{}_{:.0f}", what, 100 * w),
                     fmt::format("{} share where {:.0f} % were wanted, median", what, 100 * w),
                     quantile_estimate(where(r, what, "", w), 0.5), "%"});
  return out;
}

std::optional<Badness> badness(const Results& r, const Row& row) {
  const double truth = r.trials.number(row, "true"), predicted = r.trials.number(row, "predicted");
  if (std::isnan(truth) || std::isnan(predicted)) return std::nullopt;
  return Badness{std::abs(truth - predicted),
                 fmt::format("share {:.2f} where {:.2f} was predicted", truth, predicted)};
}

picture::Canvas plot(const Results& r) {
  std::vector<BarPanel> panels;
  for (const char* kind : kKinds) {
    BarPanel panel;
    panel.title = fmt::format("{}: true share (%) for the wanted one; mean, min, max", kind);
    panel.y_high = 100.0;
    for (const double w : kWanted) {
      const std::vector<double> truth = where(r, "true", kind, w);
      if (truth.empty()) continue;
      double sum = 0.0;
      for (const double v : truth) sum += 100.0 * v;
      panel.bars.push_back({fmt::format("{:.0f}", 100 * w), sum / static_cast<double>(truth.size()), false,
                            100 * quantile(truth, 0.0), 100 * quantile(truth, 1.0)});
      panel.levels.push_back({fmt::format("{:.0f}", 100 * w), 100 * w, picture::kCog});
    }
    if (!panel.bars.empty()) panels.push_back(std::move(panel));
  }
  return draw_bar_plot(panels);
}

}  // namespace
}  // namespace share_trials

Experiment share_experiment() {
  using namespace share_trials;
  Experiment e;
  e.name = "share";
  e.title = "The share of the load as a promise";
  e.thesis = "beyond";
  e.question =
      "Whole jobs on tables, boxes, pipes and chairs of random size and pose, the partner anywhere at his "
      "end, with 30, 40, 50, 60 and 70 % wanted in turn: which shares were said to be possible, which one "
      "was predicted, measured and true; and where another place of the partner was named for the wanted "
      "share, a second job with him there.";
  e.default_trials = 100;
  e.columns = {"layout",           "kind",
               "mass_kg",          "wanted",
               "outcome",          "reach_low",
               "reach_high",       "predicted",
               "interval_low",     "interval_high",
               "as_wished",        "tolerance",
               "measured",         "true",
               "cog_error_mm",     "tilt_deg",
               "elsewhere",        "elsewhere_predicted",
               "elsewhere_true",   "elsewhere_because",
               "cog_sigma_mm",     "partner_sigma_mm",
               "partner_error_mm", "true_lever",
               "because"};
  e.run = run;
  e.task = task();
  e.trials_set = "decision.share";
  e.figures = figures;
  e.plot = plot;
  e.badness = badness;
  return e;
}

}  // namespace colift::experiments
