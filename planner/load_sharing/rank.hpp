#pragma once

#include <cstddef>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "hal/types/result.hpp"
#include "planner/load_sharing/load_limits.hpp"
#include "planner/load_sharing/load_sharing.hpp"

namespace colift::planner {

/// Which of several robot grasps carries a task best together with a given partner grasp (thesis eq. 4.8), on
/// numbers alone. Positions in one common frame (m); wrenches in the same axes, torques about `cog` (N, N m).
struct RankProblem {
  Vec3 cog = Vec3::Zero();
  Vec3 partner = Vec3::Zero();
  std::vector<Vec3> candidates;
  std::vector<Wrench> wrenches;  ///< One per pose of the task.
  SharingWeights weights;
  std::optional<SharingLimits> limits;
};

/// What one candidate costs and how the load is shared there.
struct RankEntry {
  std::size_t candidate = 0;  ///< Index into RankProblem::candidates.
  bool feasible = false;
  double cost =
      std::numeric_limits<double>::quiet_NaN();  ///< Eq. 4.5 summed over the poses; NaN if infeasible.
  /// The robot's part of the task force along the task force, over all poses: sum f_robot.f_t / sum |f_t|^2.
  /// Between 0 and 1 for hands on both sides of the load; beyond where one hand has to push against the
  /// other. Unset if infeasible, and where no pose asks for a force.
  std::optional<double> share;
  std::vector<AgentWrenches> poses;  ///< One per wrench; empty if infeasible.
  std::string reason;                ///< Why it is infeasible, with numbers.
};

/// All candidates in the order of their cost.
struct RankResult {
  std::optional<std::size_t> best;  ///< Index of the candidate; unset where none is feasible.
  std::vector<RankEntry> ranking;  ///< Ascending cost, then the infeasible; equals in the order of the input.
};

/// Pure. Errors: BadInput for empty lists, numbers that are not finite, weights or limits out of bounds, and
/// numbers so large that a cost overflows; `where` names the entry ("candidates[3]").
[[nodiscard]] hal::Result<RankResult> rank(const RankProblem& problem);

}  // namespace colift::planner
