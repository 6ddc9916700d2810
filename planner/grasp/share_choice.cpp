#include "planner/grasp/share_choice.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace colift::planner {
namespace {

// shares that differ by less are one share to a person, and equal in doubles but for rounding
constexpr double kSame = 1e-9;

constexpr double kNoSpan_m = 1e-3;

bool feasible(const GraspCandidate& c) {
  return c.verdict == Verdict::Ok || c.verdict == Verdict::Chosen;
}

}  // namespace

std::optional<double> lever_share(const Vec3& cog, const Vec3& partner, const Vec3& robot, const Vec3& up) {
  const Vec3 line = robot - partner;
  const Vec3 span = line - up * up.dot(line);
  const double length2 = span.squaredNorm();
  if (length2 < kNoSpan_m * kNoSpan_m) return std::nullopt;
  return (cog - partner).dot(span) / length2;
}

std::optional<ShareRange> reachable_shares(std::span<const GraspCandidate> candidates,
                                           std::span<const std::optional<ScoredCandidate>> scores) {
  std::optional<ShareRange> range;
  for (std::size_t i = 0; i < std::min(candidates.size(), scores.size()); ++i) {
    if (!feasible(candidates[i]) || !scores[i]) continue;
    const double share = std::clamp(scores[i]->share, 0.0, 1.0);
    if (!range) range = {share, share};
    range->low = std::min(range->low, share);
    range->high = std::max(range->high, share);
  }
  return range;
}

std::optional<double> nearest_share(std::span<const GraspCandidate> candidates,
                                    std::span<const std::optional<ScoredCandidate>> scores, double wanted) {
  std::optional<double> nearest;
  for (std::size_t i = 0; i < std::min(candidates.size(), scores.size()); ++i) {
    if (!feasible(candidates[i]) || !scores[i]) continue;
    if (!nearest || std::abs(scores[i]->share - wanted) < std::abs(*nearest - wanted))
      nearest = scores[i]->share;
  }
  return nearest;
}

bool comes_near_share(const Decision& decision, std::size_t candidate, const DecisionConfig& config) {
  if (!decision.nearest_share) return true;
  if (candidate >= decision.scores.size() || !decision.scores[candidate]) return false;
  const double share = decision.scores[candidate]->share;
  // the window must not turn a share that is accepted into one that is refused
  if (!too_far_from_share(*decision.nearest_share, config) && too_far_from_share(share, config)) return false;
  return std::abs(share - *decision.nearest_share) <= config.share_window + kSame;
}

std::optional<std::string> too_far_from_share(double share, const DecisionConfig& config) {
  if (!config.share || !config.share_strict) return std::nullopt;
  const double off = std::abs(share - *config.share);
  if (off <= *config.share_strict + kSame) return std::nullopt;
  return fmt::format(
      "no grasp: {:.0f} % of the load were wanted, the robot would carry {:.0f} %: {:.1f} % off "
      "(limit {:.1f} %)",
      100 * *config.share, 100 * share, 100 * off, 100 * *config.share_strict);
}

}  // namespace colift::planner
