#pragma once

#include <optional>
#include <span>
#include <string>

#include "planner/grasp/grasp_decision.hpp"

namespace colift::planner {

/// Shares of the load, as fractions from 0 to 1.
struct ShareRange {
  double low = 0.0, high = 1.0;
};

/// The robot's share of a level object's weight by the lever rule: where the centre of gravity lies between
/// both hands (W, m). Hands pivot and nobody pushes sideways, so this is what is borne, whatever split the
/// cost of eq. 4.5 would like best. Below 0 or above 1 the other one has to press down. nullopt for hands
/// above each other, where the rule says nothing.
[[nodiscard]] std::optional<double> lever_share(const Vec3& cog, const Vec3& partner, const Vec3& robot,
                                                const Vec3& up);

/// From the smallest to the largest share of all candidates that are Ok or Chosen: what statics, limits, hand
/// and arm permit as the partner holds the object, cut off at 0 and 1. nullopt where none is.
[[nodiscard]] std::optional<ShareRange> reachable_shares(
    std::span<const GraspCandidate> candidates, std::span<const std::optional<ScoredCandidate>> scores);

/// The one of these shares that is nearest to `wanted`.
[[nodiscard]] std::optional<double> nearest_share(std::span<const GraspCandidate> candidates,
                                                  std::span<const std::optional<ScoredCandidate>> scores,
                                                  double wanted);

/// Whether a candidate's share is within config.share_window of decision.nearest_share; true for every one
/// where no share is wanted.
[[nodiscard]] bool comes_near_share(const Decision& decision, std::size_t candidate,
                                    const DecisionConfig& config);

/// Why a share is not accepted: farther from the wanted one than config.share_strict. nullopt where it is.
[[nodiscard]] std::optional<std::string> too_far_from_share(double share, const DecisionConfig& config);

}  // namespace colift::planner
