#include "tools/experiments/trials/tried_grasps.hpp"

#include <algorithm>
#include <limits>

namespace colift::experiments {

std::vector<std::size_t> spread_over(const std::vector<planner::GraspCandidate>& candidates,
                                     const std::vector<bool>& possible,
                                     const std::vector<std::size_t>& always, std::size_t most) {
  std::vector<std::size_t> taken;
  for (const std::size_t i : always)
    if (std::find(taken.begin(), taken.end(), i) == taken.end()) taken.push_back(i);
  std::vector<double> gap(candidates.size(), std::numeric_limits<double>::infinity());
  const auto take = [&](std::size_t i) {
    for (std::size_t k = 0; k < candidates.size(); ++k)
      gap[k] = std::min(gap[k], (candidates[k].position - candidates[i].position).norm());
  };
  for (const std::size_t i : taken) take(i);
  while (taken.size() < most) {
    std::size_t best = candidates.size();
    for (std::size_t k = 0; k < candidates.size(); ++k)
      if (possible[k] && gap[k] > 1e-3 && (best == candidates.size() || gap[k] > gap[best])) best = k;
    if (best == candidates.size()) break;
    taken.push_back(best);
    take(best);
  }
  return taken;
}

bool is_in_reach(const planner::GraspCandidate& c) {
  using planner::Verdict;
  return c.verdict == Verdict::Ok || c.verdict == Verdict::Chosen || c.verdict == Verdict::NearPartner ||
         c.verdict == Verdict::OverLimit;
}

std::vector<std::size_t> next_best(const control::Outcome& outcome, std::size_t n) {
  std::vector<std::size_t> rivals;
  for (std::size_t i = 0; i < outcome.candidates.size(); ++i)
    if (outcome.candidates[i].verdict == planner::Verdict::Ok && outcome.decision.scores[i])
      rivals.push_back(i);
  std::stable_sort(rivals.begin(), rivals.end(), [&](std::size_t a, std::size_t b) {
    return outcome.decision.scores[a]->cost < outcome.decision.scores[b]->cost;
  });
  if (rivals.size() > n) rivals.resize(n);
  return rivals;
}

DirectLift try_grasp(Observation& observation, const sim_hal::Scenario& scenario,
                     const planner::GraspCandidate& grasp, const control::Config& config, std::uint64_t seed,
                     const LiftObserver& eye) {
  DirectLift lift;
  const auto plan = observation.plan(grasp);
  if (!plan) {
    lift.reason = "no path: " + plan.error().detail;
    return lift;
  }
  auto done = lift_directly(scenario, *plan, config, seed, eye);
  if (!done) {
    lift.reason = done.error().text();
    return lift;
  }
  return *done;
}

std::string letter(std::size_t index) {
  std::string text(1, static_cast<char>('a' + index % 26));
  return index < 26 ? text : letter(index / 26 - 1) + text;
}

}  // namespace colift::experiments
