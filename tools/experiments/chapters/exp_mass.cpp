// Beyond the thesis: what a plain lift tells about mass, centre of gravity and share of an object of which
// nobody told the mass.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "sim_hal/synthetic/hash_random.hpp"
#include "tools/experiments/bar_plot.hpp"
#include "tools/experiments/experiment.hpp"
#include "tools/experiments/runs/whole_lift.hpp"
#include "tools/experiments/trials/layouts.hpp"
#include "tools/experiments/trials/random_bodies.hpp"

namespace colift::experiments {
namespace mass_trials {
namespace {

constexpr double kMassGoal = 0.05, kCogGoal_m = 0.02, kShareGoal = 0.03;
constexpr double kAlong = 0.08, kAcross = 0.05;  // of the size: contents, a drawer, a heavier wood
constexpr const char* kKinds[] = {"table", "box", "cylinder", "chair", "bodies"};

// four of five objects are of the kinds of mixed_layout(); of every second one the density is not uniform
sim_hal::Scenario layout(const Trial& trial, bool& uniform) {
  const int i = trial.index / 5;
  uniform = trial.index % 5 != 4 && i % 2 == 0;
  if (trial.index % 5 == 4) return bodies_layout(i, trial.seed);
  sim_hal::Scenario s = mixed_layout(4 * (i + 1) + trial.index % 5, trial.seed);
  if (uniform) return s;
  sim_hal::Draws draws(sim_hal::hash(trial.seed, 7900, static_cast<std::uint64_t>(trial.index)), 7900);
  const double along = draws.between(-kAlong, kAlong), across = draws.between(-kAcross, kAcross);
  if (s.object.kind == "cylinder")
    s.object.cog_offset = {along * s.object.size[1], 0.0, 0.0};
  else
    s.object.cog_offset = {along * s.object.size[0], across * s.object.size[1], 0.0};
  return s;
}

std::string inside(const control::Interval& i, double value) {
  return cell(value >= i.low && value <= i.high);
}

TrialRows run(const Trial& trial) {
  bool uniform = true;
  const sim_hal::Scenario scenario = layout(trial, uniform);
  sim_hal::SimTruth truth;
  LiftHooks hooks;
  hooks.ended = trial.watch;
  hooks.started = [&](const sim_hal::SimWorld& world) { truth = world.truth(); };
  const auto lift = run_whole_lift(scenario, trial.method, trial.own_seed(43), hooks);
  Row row{scenario.object.kind, uniform ? "uniform" : "shifted"};
  const auto short_row = [&](const std::string& outcome, const std::string& why) {
    row.push_back(outcome);
    row.resize(16);
    row.push_back(why);
    return TrialRows{row, {}, fmt::format("{}: {}: {}", scenario.object.kind, outcome, why)};
  };
  if (!lift) return short_row("failed", lift.error().text());
  const control::RunRecord& record = lift->record;
  if (!record.lift || std::isnan(lift->share_robot)) return short_row(word(record.outcome), record.reason);
  if (!record.lift->load) return short_row("not known", record.lift->load_reason);
  const control::LoadEstimate& load = *record.lift->load;
  const planner::GraspCandidate& grasp = record.decision->candidates[*record.decision->decision.chosen];
  const Eigen::Vector2d line =
      (planner::load_point(grasp) - record.decision->partner->position).head<2>().normalized();
  const double cog_m = (load.cog - truth.cog_W).head<2>().dot(line);
  for (const double v : {truth.mass_kg, load.mass_kg, load.mass_95.low, load.mass_95.high, 1e3 * cog_m,
                         1e3 * load.cog_sigma_m, lift->share_robot, load.share_robot, load.share_95.low,
                         load.share_95.high, record.lift->share_predicted})
    row.insert(row.end(), cell(v));
  row.insert(row.begin() + 2, word(record.outcome));
  row.push_back(inside(load.mass_95, truth.mass_kg));
  row.push_back(inside(load.share_95, lift->share_robot));
  row.push_back(record.reason);
  return {row,
          {},
          fmt::format("{} {}: {:.2f} kg of {:.2f}, centre of gravity {:.0f} mm off, share {:.3f} of {:.3f}",
                      scenario.object.kind, uniform ? "uniform" : "shifted", load.mass_kg, truth.mass_kg,
                      1e3 * cog_m, load.share_robot, lift->share_robot)};
}

// the figures of one part of the trials
void add_figures(const Results& r, const std::string& density, std::vector<Figure>& out) {
  int n = 0, mass = 0, cog = 0, share = 0, in_mass = 0, in_share = 0, predicted = 0;
  for (const Row& row : r.trials.rows()) {
    const double kg = r.trials.number(row, "kg");
    if (r.trials.text(row, "density") != density || std::isnan(kg)) continue;
    ++n;
    const double true_share = r.trials.number(row, "share_true");
    mass += std::abs(kg / r.trials.number(row, "kg_true") - 1.0) <= kMassGoal;
    cog += std::abs(r.trials.number(row, "cog_mm")) <= 1e3 * kCogGoal_m;
    share += std::abs(r.trials.number(row, "share") - true_share) <= kShareGoal;
    predicted += std::abs(r.trials.number(row, "predicted") - true_share) <= 0.05;
    in_mass += r.trials.number(row, "mass_inside") > 0.5;
    in_share += r.trials.number(row, "share_inside") > 0.5;
  }
  const std::string of = density + " density: ";
  out.push_back({"mass_" + density, of + "mass within 5 %", rate(mass, n), "%", 0.95, true});
  out.push_back({"cog_" + density, of + "centre of gravity within 2 cm", rate(cog, n), "%", 0.90, true});
  out.push_back({"share_" + density, of + "share within 0.03", rate(share, n), "%", 0.95, true});
  out.push_back(
      {"predicted_" + density, of + "predicted share within 0.05", rate(predicted, n), "%", 0.95, true});
  out.push_back(
      {"mass_inside_" + density, of + "true mass inside its interval", rate(in_mass, n), "%", 0.93, true});
  out.push_back(
      {"share_inside_" + density, of + "true share inside its interval", rate(in_share, n), "%", 0.93, true});
}

std::vector<Figure> figures(const Results& r) {
  std::vector<Figure> out;
  int n = 0, known = 0;
  for (const Row& row : r.trials.rows()) {
    const std::string outcome = r.trials.text(row, "outcome");
    const bool estimated = !std::isnan(r.trials.number(row, "kg"));
    if (!estimated && outcome != "not known") continue;
    ++n;
    known += estimated;
  }
  out.push_back({"known", "lifts after which mass and share are known", rate(known, n), "%"});
  add_figures(r, "uniform", out);
  add_figures(r, "shifted", out);
  return out;
}

// errors over their goals
std::optional<Badness> badness(const Results& r, const Row& row) {
  const auto at = [&](const char* column) { return r.trials.number(row, column); };
  if (std::isnan(at("kg"))) return std::nullopt;
  const double mass = std::abs(at("kg") / at("kg_true") - 1.0), cog_m = 1e-3 * std::abs(at("cog_mm"));
  const double share = std::abs(at("share") - at("share_true"));
  return Badness{std::max({mass / kMassGoal, cog_m / kCogGoal_m, share / kShareGoal}),
                 fmt::format("mass {:.1f} % off, centre of gravity {:.0f} mm, share {:.3f}", 100.0 * mass,
                             1e3 * cog_m, share)};
}

picture::Canvas plot(const Results& r) {
  BarPanel mass{"Error of the mass, median (%)", {}, {}, {}};
  for (const char* kind : kKinds) {
    std::vector<double> errors;
    for (const Row& row : r.trials.rows()) {
      const double kg = r.trials.number(row, "kg");
      if (r.trials.text(row, "object") == kind && !std::isnan(kg))
        errors.push_back(100.0 * std::abs(kg / r.trials.number(row, "kg_true") - 1.0));
    }
    if (!errors.empty()) mass.bars.push_back({kind, quantile_estimate(errors, 0.5).value});
  }
  return draw_bar_plot({mass});
}

}  // namespace
}  // namespace mass_trials

Experiment mass_experiment() {
  using namespace mass_trials;
  Experiment e;
  e.name = "mass";
  e.title = "Mass, centre of gravity and share after a plain lift";
  e.thesis = "beyond it";
  e.question =
      "Tables, boxes, pipes, chairs and furniture of several bodies are lifted once; nobody says what they "
      "weigh. Of one half the density is uniform, of the other it is not. How well are mass, centre of "
      "gravity and share known, and do their intervals of 95 % hold?";
  e.default_trials = 200;
  e.columns = {"object",     "density",   "outcome",     "kg_true",      "kg",     "kg_low",
               "kg_high",    "cog_mm",    "cog_sigma",   "share_true",   "share",  "share_low",
               "share_high", "predicted", "mass_inside", "share_inside", "because"};
  e.run = run;
  e.figures = figures;
  e.plot = plot;
  e.badness = badness;
  return e;
}

}  // namespace colift::experiments
