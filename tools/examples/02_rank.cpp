// Which of several places is best for the robot, on numbers alone: two carry a beam of 6 kg, the partner
// holds one end, and the robot may grasp at five places. No camera, no robot, units are m, N and N m.
//
//   build/example_02_rank

#include <fmt/format.h>

#include <cmath>

#include "planner/load_sharing/rank.hpp"

int main() {
  using namespace colift;
  constexpr double kWeight_n = 6.0 * 9.81;

  planner::RankProblem problem;
  problem.cog = {0.10, 0.0, 0.0};  // the beam is heavier on the robot's side
  problem.partner = {-0.80, 0.0, 0.0};
  for (const double x_m : {0.05, 0.30, 0.55, 0.80, 1.00}) problem.candidates.push_back({x_m, 0.0, 0.0});
  problem.wrenches = {{{0, 0, kWeight_n}, {0, 0, 0}}};  // carry it: up, and no torque

  const auto result = planner::rank(problem);
  if (!result) return fmt::print(stderr, "{}\n", result.error().text()), 2;

  fmt::print("  place x    cost (N^2)   robot's share   partner's torque\n");
  for (const planner::RankEntry& entry : result->ranking) {
    const double x_m = problem.candidates[entry.candidate].x();
    if (!entry.feasible) {
      fmt::print("  {:5.2f} m    not possible: {}\n", x_m, entry.reason);
      continue;
    }
    fmt::print("  {:5.2f} m    {:10.1f}   {:11.0f} %   {:12.2f} N m\n", x_m, entry.cost,
               100.0 * entry.share.value_or(NAN), entry.poses.front().partner.torque.norm());
  }
  // as far behind the centre of gravity as the partner is before it: the load is shared equally, without
  // torque
  const bool expected = result->best && problem.candidates[*result->best].x() == 1.00;
  fmt::print("best: x = {:.2f} m\n", problem.candidates[result->best.value_or(0)].x());
  return expected ? 0 : 1;
}
