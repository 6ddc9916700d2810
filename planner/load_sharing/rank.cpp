#include "planner/load_sharing/rank.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace colift::planner {
namespace {

using hal::ErrorCode;
using hal::failure;

hal::Result<> check_vector(const std::string& where, const Vec3& v) {
  for (int k = 0; k < 3; ++k) {
    if (!std::isfinite(v[k])) {
      return failure(ErrorCode::BadInput, fmt::format("{}[{}]", where, k),
                     fmt::format("is {}, expected a finite number", v[k]));
    }
  }
  return {};
}

hal::Result<> check(const RankProblem& p) {
  if (auto ok = check_vector("cog", p.cog); !ok) return ok;
  if (auto ok = check_vector("partner", p.partner); !ok) return ok;
  if (p.candidates.empty())
    return failure(ErrorCode::BadInput, "candidates", "is empty, expected at least one position");
  if (p.wrenches.empty())
    return failure(ErrorCode::BadInput, "wrenches", "is empty, expected at least one wrench");
  for (std::size_t i = 0; i < p.candidates.size(); ++i) {
    if (p.candidates[i].allFinite()) continue;
    return check_vector(fmt::format("candidates[{}]", i), p.candidates[i]);
  }
  for (std::size_t i = 0; i < p.wrenches.size(); ++i) {
    if (auto ok = check_vector(fmt::format("wrenches[{}].force", i), p.wrenches[i].force); !ok) return ok;
    if (auto ok = check_vector(fmt::format("wrenches[{}].torque", i), p.wrenches[i].torque); !ok) return ok;
  }
  return {};
}

RankEntry assess(const RankProblem& problem, const LimitedSharing& limited, std::size_t index) {
  const LoadSharing& sharing = limited.sharing();
  const Vec3 p1 = problem.partner - problem.cog, p2 = problem.candidates[index] - problem.cog;
  RankEntry entry;
  entry.candidate = index;
  entry.poses.reserve(problem.wrenches.size());
  double cost = 0.0, carried = 0.0, asked = 0.0;
  for (std::size_t i = 0; i < problem.wrenches.size(); ++i) {
    const Wrench& task = problem.wrenches[i];
    AgentWrenches w = sharing.wrenches(p1, p2, task);
    if (limited.within(w)) {
      cost += sharing.cost(p1, p2, task);
    } else {
      const auto best = limited.wrenches(p1, p2, task);
      if (!best) {
        const auto missing = limited.shortfall(p1, p2, task);
        entry.reason = missing ? missing->text()
                               : "no wrenches within the limits balance this pose to rounding: its numbers "
                                 "are too far apart";
        if (problem.wrenches.size() > 1) entry.reason = fmt::format("pose {}: {}", i, entry.reason);
        entry.poses.clear();
        return entry;
      }
      w = *best;
      cost += sharing.cost_weight(w);
    }
    carried += w.robot.force.dot(task.force);
    asked += task.force.squaredNorm();
    entry.poses.push_back(w);
  }
  entry.feasible = true;
  entry.cost = cost;
  if (asked > 0.0) entry.share = carried / asked;
  return entry;
}

}  // namespace

hal::Result<RankResult> rank(const RankProblem& problem) {
  if (auto ok = check(problem); !ok) return tl::unexpected(ok.error());
  const auto sharing = LoadSharing::create(problem.weights);
  if (!sharing) return tl::unexpected(sharing.error());
  const auto limited = LimitedSharing::create(*sharing, problem.limits.value_or(SharingLimits{}));
  if (!limited) return tl::unexpected(limited.error());

  RankResult result;
  result.ranking.reserve(problem.candidates.size());
  for (std::size_t i = 0; i < problem.candidates.size(); ++i) {
    RankEntry entry = assess(problem, *limited, i);
    const bool sane =
        !entry.feasible || (std::isfinite(entry.cost) && std::isfinite(entry.share.value_or(0.0)));
    if (!sane) {
      return failure(
          ErrorCode::BadInput, fmt::format("candidates[{}]", i),
          "the cost of this grasp is not a finite number: positions, wrenches or weights are too large");
    }
    result.ranking.push_back(std::move(entry));
  }
  std::stable_sort(result.ranking.begin(), result.ranking.end(), [](const RankEntry& a, const RankEntry& b) {
    if (a.feasible != b.feasible) return a.feasible;
    return a.feasible && a.cost < b.cost;
  });
  if (result.ranking.front().feasible) result.best = result.ranking.front().candidate;
  return result;
}

}  // namespace colift::planner
