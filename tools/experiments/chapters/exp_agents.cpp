// Beyond one partner: where he should rather grasp, more than one of them, a robot in his place.

#include <fmt/format.h>

#include <cmath>

#include "control/session/suggest.hpp"
#include "hal/types/units.hpp"
#include "planner/grasp/task_choice.hpp"
#include "sim_hal/synthetic/hash_random.hpp"
#include "tools/experiments/bar_plot.hpp"
#include "tools/experiments/experiment.hpp"
#include "tools/experiments/trials/asked_partner.hpp"
#include "tools/experiments/trials/layouts.hpp"
#include "tools/experiments/trials/tried_grasps.hpp"

namespace colift::experiments {
namespace agents_trials {
namespace {

using planner::CarryingAgent;

constexpr double kHeight_m = 0.05, kHold_s = 1.0;

control::TaskSaid task() {
  return {"experiment agents", kHeight_m, kHold_s};
}
constexpr double kSidePart = 0.6;         // of the table's length, from the far end
constexpr double kInside = 0.9;           // a hand is not at the very corner
constexpr double kApart_m = 0.3;          // two people
constexpr double kWeakRobotWeight = 4.0;  // a first agent who should bear a fifth of what the robot bears

/// A table whose partner takes hold anywhere at its far end or in the far part of its sides.
sim_hal::Scenario table_taken_anywhere(const Trial& trial) {
  sim_hal::Scenario scenario = table_layout(trial.index + 2, trial.seed);
  sim_hal::Draws draws(trial.own_seed(12), 7950);
  const Eigen::Vector2d half(0.5 * scenario.object.size[0], 0.5 * scenario.object.size[1]);
  const double far = 2.0 * half.y(), side = kSidePart * 2.0 * half.x();
  const double along = draws.between(0.0, far + 2.0 * side);
  hal::Vec3& grasp = scenario.partner.grasp;
  if (along < far) {
    grasp.head<2>() = Eigen::Vector2d(half.x(), kInside * (along - half.y()));
  } else {
    const bool left = along < far + side;
    const double back = along - far - (left ? 0.0 : side);
    grasp.head<2>() = Eigen::Vector2d(kInside * half.x() - back, left ? half.y() : -half.y());
  }
  return scenario;
}

/// One decision and what it was worth.
struct Lifted {
  control::Outcome outcome;
  hal::Vec3 cog = hal::Vec3::Zero(), true_cog = hal::Vec3::Zero(), true_partner = hal::Vec3::Zero();
  double effort = NAN;  ///< Eq. 4.5 for a kilogram lifted, with everything where it truly is (N^2).
  DirectLift lift;
  std::optional<control::Suggestion> suggestion;

  [[nodiscard]] bool possible() const { return outcome.decision.chosen.has_value(); }
};

hal::Result<Lifted> decide_and_lift(const sim_hal::Scenario& scenario, const Trial& trial,
                                    std::uint64_t seed) {
  auto observation = Observation::make(scenario, trial.method, seed, kHeight_m);
  if (!observation) return tl::unexpected(observation.error());
  control::Config config = config_for(trial.method, task());
  auto outcome = (*observation)->decide(config);
  if (!outcome) return tl::unexpected(outcome.error());
  const auto sharing = planner::LoadSharing::create(config.decision.weights);
  if (!sharing) return tl::unexpected(sharing.error());
  Lifted l;
  l.outcome = std::move(*outcome);
  l.cog = (*observation)->analysis().scene.target->cog;
  l.true_cog = (*observation)->true_cog();
  l.true_partner = (*observation)->true_partner();
  l.suggestion = control::suggest_to_partner(l.outcome, (*observation)->analysis().candidates, l.cog,
                                             hal::Vec3::UnitZ(), config.decision);
  l.lift.reason = l.outcome.decision.reason;
  if (!l.possible()) return l;
  const planner::GraspCandidate& chosen = l.outcome.candidates[*l.outcome.decision.chosen];
  const hal::Wrench lift{{0.0, 0.0, hal::kGravity_m_s2}, hal::Vec3::Zero()};
  l.effort = sharing->cost(l.true_partner - l.true_cog, planner::load_point(chosen) - l.true_cog, lift);
  l.lift = try_grasp(**observation, scenario, chosen, config, seed);
  return l;
}

/// What the choice that knows of all agents saves against one that takes them for one person, part of 1.
std::optional<double> saved_by_knowing(const Lifted& l, const std::vector<CarryingAgent>& others_seen,
                                       const std::vector<CarryingAgent>& others_true,
                                       const control::Config& config) {
  const planner::SharingWeights& w = config.decision.weights;
  const CarryingAgent robot{hal::Vec3::Zero(), w.epsilon * w.epsilon, w.omega2_per_m};
  const std::vector<hal::Wrench> lift{{{0.0, 0.0, hal::kGravity_m_s2}, hal::Vec3::Zero()}};
  const double near_m = config.decision.near_partner_m;
  const CarryingAgent person{others_seen[0].position, 1.0, w.omega1_per_m};
  const auto knowing = choose_beside(l.outcome.candidates, others_seen, robot, l.cog, lift, near_m);
  const auto blind = choose_beside(l.outcome.candidates, {&person, 1}, robot, l.cog, lift, near_m);
  if (!knowing || !blind || !knowing->best || !blind->best) return std::nullopt;
  const auto true_cost = [&](std::size_t i) {
    std::vector<CarryingAgent> all = others_true;
    all.push_back(robot);
    all.back().position = planner::load_point(l.outcome.candidates[i]) - l.true_cog;
    const auto agents = planner::SeveralAgents::create(std::move(all));
    return agents ? agents->cost(lift) : NAN;
  };
  return 1.0 - true_cost(*knowing->best) / true_cost(*blind->best);
}

/// What two choices save that know of more than one person; NaN where nothing can be chosen.
struct Knowing {
  double two_partners = NAN, weak_robot = NAN;
};

Knowing value_of_knowing(const Lifted& l, const control::Config& config, std::uint64_t seed) {
  Knowing saved;
  if (!l.possible()) return saved;
  const planner::SharingWeights& w = config.decision.weights;
  const CarryingAgent seen{l.outcome.partner->position - l.cog, 1.0, w.omega1_per_m};
  const CarryingAgent true_first{l.true_partner - l.true_cog, 1.0, w.omega1_per_m};
  std::vector<hal::Vec3> places;
  for (const planner::GraspCandidate& c : l.outcome.candidates)
    if ((planner::load_point(c) - l.outcome.partner->position).norm() > kApart_m)
      places.push_back(planner::load_point(c));
  if (!places.empty()) {
    sim_hal::Draws draws(seed, 7900);
    const auto pick = static_cast<std::size_t>(draws.between(0.0, static_cast<double>(places.size()) - 1e-9));
    CarryingAgent second = seen, second_true = true_first;
    second.position = places[pick] - l.cog;
    second_true.position = places[pick] - l.true_cog;
    saved.two_partners = saved_by_knowing(l, {seen, second}, {true_first, second_true}, config).value_or(NAN);
  }
  CarryingAgent weak = seen, weak_true = true_first;
  weak.force_weight = weak_true.force_weight = kWeakRobotWeight;
  saved.weak_robot = saved_by_knowing(l, {weak}, {weak_true}, config).value_or(NAN);
  return saved;
}

TrialRows run(const Trial& trial) {
  const std::uint64_t seed = trial.own_seed(11);
  const sim_hal::Scenario scenario = table_taken_anywhere(trial);
  const auto before = decide_and_lift(scenario, trial, seed);
  if (!before) {
    Row row{scenario.name, cell(scenario.object.mass)};
    row.resize(12);
    row.push_back(before.error().text());
    return {row, {}, scenario.name + ": " + before.error().text()};
  }
  // he goes where he was told to, and everything is seen and decided anew
  double moved_m = NAN, realised = NAN, tilt_after = NAN;
  std::string reason = before->lift.reason, words = "stands well";
  bool lifted_after = false;
  if (before->suggestion) {
    const control::Suggestion& told = *before->suggestion;
    moved_m = (told.position - before->outcome.partner->position).norm();
    words = told.reason;
    const auto after = decide_and_lift(partner_goes_to(scenario, told.position, seed), trial, seed);
    if (after) {
      realised = 1.0 - after->effort / before->effort;
      lifted_after = after->lift.lifted;
      if (lifted_after) tilt_after = after->lift.tilt_deg;
    }
    reason = after ? after->lift.reason : after.error().text();
  }
  const Knowing saved = value_of_knowing(*before, config_for(trial.method, task()), seed);
  return {{scenario.name, cell(scenario.object.mass), cell(before->possible()),
           cell(before->suggestion.has_value()), cell(moved_m),
           cell(before->suggestion ? before->suggestion->gain.value_or(NAN) : NAN), cell(realised),
           cell(before->lift.lifted ? before->lift.tilt_deg : NAN), cell(lifted_after), cell(tilt_after),
           cell(saved.two_partners), cell(saved.weak_robot), reason},
          {},
          fmt::format("{}: {}", scenario.name, words)};
}

std::vector<Figure> figures(const Results& r) {
  std::vector<double> expected, realised, difference, before, after, two, robot;
  int n = 0, possible = 0, told = 0, told_when_refused = 0, lifted_after = 0, better = 0;
  for (const Row& row : r.trials.rows()) {
    if (r.trials.text(row, "possible").empty()) continue;
    ++n;
    for (const auto& [column, to] :
         {std::pair{"two_partners_saved", &two}, std::pair{"weak_robot_saved", &robot}})
      if (const double v = r.trials.number(row, column); !std::isnan(v)) to->push_back(v);
    const bool could = r.trials.number(row, "possible") > 0.5;
    possible += could;
    if (r.trials.number(row, "suggested") < 0.5) continue;
    ++told;
    const bool lifted = r.trials.number(row, "lifted_after") > 0.5;
    if (!could) {
      ++told_when_refused;
      lifted_after += lifted;
    }
    const double gain = r.trials.number(row, "realised_gain");
    if (lifted) after.push_back(r.trials.number(row, "tilt_after_deg"));
    if (std::isnan(gain)) continue;
    const double hoped = r.trials.number(row, "expected_gain");
    expected.push_back(hoped);
    realised.push_back(gain);
    difference.push_back(gain - hoped);
    better += gain > 0.0;
    before.push_back(r.trials.number(row, "tilt_before_deg"));
  }
  return {{"possible", "layouts in which the robot has a grasp as he stands", rate(possible, n), "%"},
          {"told", "layouts in which the partner is asked to grasp elsewhere", rate(told, n), "%"},
          {"helped", "... of those without a grasp before, lifted after he went there",
           rate(lifted_after, told_when_refused), "%"},
          {"expected", "... effort saved, as predicted to him, mean", mean_estimate(expected), "%"},
          {"realised", "... effort saved when he went there and all was decided anew, mean",
           mean_estimate(realised), "%", 0.0, true},
          {"realised_less_expected", "... the difference, mean", mean_estimate(difference), "%"},
          {"better", "... of those who went, with less effort than before",
           rate(better, static_cast<int>(realised.size())), "%"},
          {"tilt_p95_before", "... tilt where he stood, 95 % below", quantile_estimate(before, 0.95), "deg"},
          {"tilt_p95_after", "... tilt where he went, 95 % below", quantile_estimate(after, 0.95), "deg"},
          {"two_partners", "two partners: effort saved by a choice that knows both, mean", mean_estimate(two),
           "%", 0.0, true},
          {"weak_robot",
           "a robot four times as dear as first agent: effort saved by a choice that knows it, mean",
           mean_estimate(robot), "%", 0.0, true}};
}

picture::Canvas plot(const Results& r) {
  BarPanel told{"Told to go elsewhere: effort saved, mean (%)", {}, {}, {}},
      knowing{"Choice that knows of all who carry: effort saved, mean (%)", {}, {}, {}};
  for (const Figure& f : figures(r)) {
    const bool suggestion = f.key == "expected" || f.key == "realised";
    if (!suggestion && f.key != "two_partners" && f.key != "weak_robot") continue;
    (suggestion ? told : knowing).bars.push_back(percent_bar(f.key, f.estimate));
  }
  return draw_bar_plot({told, knowing});
}

}  // namespace
}  // namespace agents_trials

Experiment agents_experiment() {
  using namespace agents_trials;
  Experiment e;
  e.name = "agents";
  e.title = "Who else carries, and where he should grasp";
  e.thesis = "beyond it";
  e.question =
      "A table and a partner anywhere at its far end or its sides. He is told where he should rather take "
      "hold, goes there, and all is seen, decided and lifted anew. Then, computed with everything where it "
      "truly is: a second person at a place drawn from the object's edges, and a weaker robot in the "
      "person's place; what does the choice save that knows of them?";
  e.default_trials = 100;
  e.columns = {"layout",       "mass_kg",        "possible",           "suggested",
               "moved_m",      "expected_gain",  "realised_gain",      "tilt_before_deg",
               "lifted_after", "tilt_after_deg", "two_partners_saved", "weak_robot_saved",
               "because"};
  e.run = run;
  e.task = task();
  e.figures = figures;
  e.plot = plot;
  return e;
}

}  // namespace colift::experiments
