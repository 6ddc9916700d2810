// Beyond the thesis: a choice that knows what it does not know.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "sim_hal/synthetic/hash_random.hpp"
#include "tools/experiments/bar_plot.hpp"
#include "tools/experiments/experiment.hpp"
#include "tools/experiments/trials/box_in_line.hpp"
#include "tools/experiments/trials/layouts.hpp"
#include "tools/experiments/trials/tried_grasps.hpp"

namespace colift::experiments {
namespace robust_trials {
namespace {

constexpr double kBoxShare = 0.3;  // laid out for it: the partner holds near the middle
constexpr double kHeight_m = 0.05, kHold_s = 1.0;

control::TaskSaid task() {
  return {"experiment robust", kHeight_m, kHold_s};
}
// what the best grip of a box holds: of heavier or smoother ones every grip slips, whatever is chosen
constexpr double kLightest_kg = 3.0, kHeaviest_kg = 6.0, kSmoothest = 0.5, kRoughest = 0.9;
constexpr double kSlip_m = 0.005;                  // of the object in the hand: the grip slips
constexpr double kMost = 0.4;                      // of the size: the centre of gravity stays inside
constexpr double kLess_deg = 0.01, kFewer = 0.01;  // lower means lower, not equal
constexpr const char* kAims[] = {"nominal", "expected", "worst"};

double normal(sim_hal::Draws& draws) {
  const double r = std::sqrt(-2.0 * std::log(1.0 - draws.between(0.0, 0.999)));
  return r * std::cos(2.0 * std::numbers::pi * draws.between(0.0, 1.0));
}

TrialRows run(const Trial& trial) {
  const std::uint64_t seed = trial.own_seed(5);
  const bool table = trial.index % 2 == 0;
  sim_hal::Scenario scenario =
      table ? table_layout(trial.index / 2 + 2, trial.seed) : box_in_line(trial.index, trial.seed, kBoxShare);
  sim_hal::Draws draws(seed, 7500);
  const double unevenness = config_for(trial.method, task()).decision.unevenness;
  hal::Vec3& off = scenario.object.cog_offset;
  for (int axis = 0; axis < 2; ++axis) {
    const double size = scenario.object.size[static_cast<std::size_t>(axis)];
    off[axis] = size * std::clamp(unevenness * normal(draws), -kMost, kMost);
  }
  if (!table) {
    scenario.object.mass = draws.between(kLightest_kg, kHeaviest_kg);
    scenario.object.friction = draws.between(kSmoothest, kRoughest);
  }
  const Row head{scenario.name, table ? "table" : "box", cell(scenario.object.mass),
                 cell(scenario.object.friction), cell(1e3 * off.norm())};
  const auto refused = [&](const std::string& why) {
    Row row = head;
    row.resize(head.size() + 9);
    row.push_back(why);
    return TrialRows{row, {}, scenario.name + ": " + why};
  };
  auto observation = Observation::make(scenario, trial.method, seed, kHeight_m);
  if (!observation) return refused(observation.error().text());

  TrialRows rows;
  rows.row = head;
  std::string reason, words;
  std::vector<std::pair<int, DirectLift>> done;
  for (const char* aim : kAims) {
    const control::Config config =
        config_for(trial.method, task(),
                   {{"decision.mass_kg", fmt::format("{}", scenario.object.mass)}, {"decision.robust", aim}});
    const auto outcome = (*observation)->decide(config);
    if (!outcome) return refused(outcome.error().text());
    if (!outcome->decision.chosen) return refused(outcome->decision.reason);
    const planner::GraspCandidate& grasp = outcome->candidates[*outcome->decision.chosen];
    auto known = std::find_if(done.begin(), done.end(), [&](const auto& d) { return d.first == grasp.id; });
    if (known == done.end())
      known = done.insert(done.end(), {grasp.id, try_grasp(**observation, scenario, grasp, config, seed)});
    const DirectLift& lift = known->second;
    const bool yields = lift.held && (!lift.lifted || lift.slip_m > kSlip_m);
    rows.row.push_back(cell(grasp.id));
    // what slips has no top at which it hangs: how far it turned at most
    rows.row.push_back(cell(yields ? lift.most_tilt_deg : lift.lifted ? lift.tilt_deg : NAN));
    rows.row.push_back(lift.held ? cell(yields) : "");
    if (!lift.reason.empty()) reason = lift.reason;
    words += fmt::format("{} {} {}{:.2f} deg", words.empty() ? ":" : ",", aim, yields ? "slips, " : "",
                         lift.tilt_deg);
  }
  rows.row.push_back(reason);
  rows.words = scenario.name + words;
  return rows;
}

/// What both of two choices came to in each layout.
struct Paired {
  std::vector<double> nominal, robust;
};

// `kind` empty: of both
Paired paired(const Results& r, const std::string& kind, const std::string& column, const std::string& aim) {
  Paired p;
  for (const Row& row : r.trials.rows()) {
    if (!kind.empty() && r.trials.text(row, "kind") != kind) continue;
    const double a = r.trials.number(row, "nominal_" + column), b = r.trials.number(row, aim + "_" + column);
    if (std::isnan(a) || std::isnan(b)) continue;
    p.nominal.push_back(a);
    p.robust.push_back(b);
  }
  return p;
}

// by how much the robust choice lowers a quantile, layouts drawn anew in pairs (Efron 1979)
Estimate lowered(const Paired& p, double part) {
  constexpr int kResamples = 2000;
  const int n = static_cast<int>(p.nominal.size());
  if (n == 0) return {NAN, NAN, NAN, 0};
  sim_hal::Draws draws(1, 6101);
  std::vector<double> differences, a(p.nominal.size()), b(p.nominal.size());
  for (int i = 0; i < kResamples; ++i) {
    for (std::size_t k = 0; k < a.size(); ++k) {
      const auto from = static_cast<std::size_t>(draws.below(n));
      a[k] = p.nominal[from];
      b[k] = p.robust[from];
    }
    differences.push_back(quantile(a, part) - quantile(b, part));
  }
  return {quantile(p.nominal, part) - quantile(p.robust, part), quantile(differences, 0.025),
          quantile(differences, 0.975), n};
}

std::vector<Figure> figures(const Results& r) {
  std::vector<Figure> out;
  for (const char* aim : kAims) {
    const std::string name = aim;
    const std::vector<double> tilts = paired(r, "table", "tilt_deg", aim).robust;
    const std::vector<double> slips = paired(r, "box", "slipped", aim).robust;
    out.push_back({"tilt_median_" + name, fmt::format("tables, tilt of the {} choice, median", name),
                   quantile_estimate(tilts, 0.5), "deg"});
    out.push_back({"tilt_p95_" + name, fmt::format("tables, tilt of the {} choice, 95 % below", name),
                   quantile_estimate(tilts, 0.95), "deg"});
    out.push_back({"box_tilt_p95_" + name, fmt::format("boxes, tilt of the {} choice, 95 % below", name),
                   quantile_estimate(paired(r, "box", "tilt_deg", aim).robust, 0.95), "deg"});
    out.push_back(
        {"slipped_" + name, fmt::format("boxes, {} choice slipped by more than 5 mm", name),
         rate(static_cast<int>(std::count(slips.begin(), slips.end(), 1.0)), static_cast<int>(slips.size())),
         "%"});
  }
  for (const std::string aim : {"expected", "worst"}) {
    out.push_back({"tilt_p95_lowered_" + aim, fmt::format("all, 95 % tilt lowered by the {} choice", aim),
                   lowered(paired(r, "", "tilt_deg", aim), 0.95), "deg", kLess_deg, true});
    out.push_back({"table_tilt_p95_lowered_" + aim,
                   fmt::format("tables, 95 % tilt lowered by the {} choice", aim),
                   lowered(paired(r, "table", "tilt_deg", aim), 0.95), "deg"});
    out.push_back({"box_tilt_p95_lowered_" + aim,
                   fmt::format("boxes, 95 % tilt lowered by the {} choice", aim),
                   lowered(paired(r, "box", "tilt_deg", aim), 0.95), "deg", kLess_deg, true});
    const Paired slips = paired(r, "box", "slipped", aim);
    std::vector<double> saved;
    for (std::size_t i = 0; i < slips.nominal.size(); ++i)
      saved.push_back(slips.nominal[i] - slips.robust[i]);
    out.push_back({"slips_saved_" + aim, fmt::format("boxes, fewer that slip with the {} choice", aim),
                   mean_estimate(saved), "%", kFewer, true});
  }
  int differ = 0, n = 0;
  for (const Row& row : r.trials.rows()) {
    if (r.trials.text(row, "nominal_id").empty()) continue;
    ++n;
    differ += r.trials.text(row, "nominal_id") != r.trials.text(row, "expected_id");
  }
  out.push_back({"choices_differ", "layouts in which both choose differently", rate(differ, n), "%"});
  return out;
}

picture::Canvas plot(const Results& r) {
  BarPanel tilt{"Tables: tilt, 95 % below (deg)", {}, {}, {}},
      box{"Boxes: tilt, 95 % below (deg)", {}, {}, {}}, slip{"Boxes: slipped (%)", {}, {}, {}};
  for (const Figure& f : figures(r)) {
    const std::string aim = f.key.substr(f.key.rfind('_') + 1);
    const Estimate& e = f.estimate;
    if (f.key == "tilt_p95_" + aim) tilt.bars.push_back({aim, e.value, false, e.low, e.high});
    if (f.key == "box_tilt_p95_" + aim) box.bars.push_back({aim, e.value, false, e.low, e.high});
    if (f.key == "slipped_" + aim)
      slip.bars.push_back({aim, 100 * e.value, false, 100 * e.low, 100 * e.high});
  }
  return draw_bar_plot({tilt, box, slip});
}

}  // namespace
}  // namespace robust_trials

Experiment robust_experiment() {
  using namespace robust_trials;
  Experiment e;
  e.name = "robust";
  e.title = "Choice over an uncertain centre of gravity";
  e.thesis = "beyond it";
  e.question =
      "Tables, and boxes whose partner holds not far from the middle, with a centre of gravity that uneven "
      "density has moved by a normal deviate of 5 % of each side. Lifted with the nominal choice and with "
      "those that minimise the expected and the worst cost over 10 000 what-ifs. The mass is known, the "
      "friction is not.";
  e.default_trials = 100;
  e.columns = {"layout", "kind", "mass_kg", "friction", "cog_off_mm"};
  for (const std::string aim : kAims)
    for (const char* column : {"id", "tilt_deg", "slipped"}) e.columns.push_back(aim + "_" + column);
  e.columns.emplace_back("because");
  e.run = run;
  e.task = task();
  e.trials_set = "decision.mass_kg, decision.robust";
  e.figures = figures;
  e.plot = plot;
  return e;
}

}  // namespace colift::experiments
