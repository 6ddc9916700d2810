#include "control/test_lift/level_grip.hpp"

#include <fmt/format.h>

#include <cmath>
#include <utility>

namespace colift::control {
namespace {

/// A grasp of one of the decisions.
struct Origin {
  std::size_t decision = 0, candidate = 0;
};

void choose(Outcome& outcome, std::size_t candidate, const NextGrip& grip) {
  using planner::Verdict;
  planner::Decision& decision = outcome.decision;
  if (decision.chosen) outcome.candidates[*decision.chosen].verdict = Verdict::Ok;
  decision.chosen = candidate;
  decision.share = grip.share;
  if (const auto& score = decision.scores[candidate]) decision.cost = score->cost;
  planner::GraspCandidate& c = outcome.candidates[candidate];
  c.verdict = Verdict::Chosen;
  decision.reason =
      fmt::format("grasp {}: after the test lifts it holds the object level with a probability of {:.0f} %",
                  c.id, 1e2 * grip.chance);
  c.reason = decision.reason;
}

}  // namespace

std::vector<hal::Vec3> likely_places(const CarriedObject& object, const hal::Vec3& held,
                                     const CogBelief& belief) {
  const Eigen::Vector2d partner = held.head<2>(), arm = belief.mean() - partner;
  const Eigen::Vector2d across = Eigen::Vector2d(-arm.y(), arm.x()).normalized();
  const double spread = std::sqrt(across.dot(belief.covariance() * across));
  std::vector<hal::Vec3> all;
  for (const double aside : {0.0, -spread, spread}) {
    for (const double far : {1.0, 0.6, 0.8, 1.2}) {
      all.push_back(object.cog);
      all.back().head<2>() = partner + far * arm + aside * across;
    }
  }
  return all;
}

std::optional<LevelGrip> choose_level_grip(const DecideAt& decide, const CarriedObject& object,
                                           const hal::Vec3& partner, std::span<const MeasuredLift> tests,
                                           const CogBelief& belief, double wanted_share,
                                           const TestLiftConfig& config) {
  std::vector<Outcome> outcomes;
  std::vector<planner::GraspCandidate> grasps;
  std::vector<Origin> origins;
  for (const hal::Vec3& cog : likely_places(object, partner, belief)) {
    auto outcome = decide(cog);
    if (!outcome) continue;
    for (std::size_t i = 0; i < outcome->candidates.size(); ++i) {
      grasps.push_back(outcome->candidates[i]);
      origins.push_back({outcomes.size(), i});
    }
    outcomes.push_back(std::move(*outcome));
  }
  const auto next = next_grip(grasps, partner, tests, belief, wanted_share, config);
  if (!next) return std::nullopt;
  const Origin from = origins[next->index];
  LevelGrip grip{std::move(outcomes[from.decision]), next->chance};
  choose(grip.outcome, from.candidate, *next);
  return grip;
}

}  // namespace colift::control
