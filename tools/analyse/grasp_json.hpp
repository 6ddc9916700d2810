#pragma once

#include <nlohmann/json_fwd.hpp>

#include "control/session/decide.hpp"
#include "hal/types/geometry.hpp"

namespace colift::tools {

// Parts that several documents share. For .cpp files of this folder only: JSON stays out of other headers.

[[nodiscard]] nlohmann::ordered_json json_array(const hal::Vec3& v);

/// Standard deviations along the axes.
[[nodiscard]] nlohmann::ordered_json json_sigma(const Eigen::Matrix3d& covariance);

[[nodiscard]] nlohmann::ordered_json candidate_json(const planner::GraspCandidate& candidate);

/// Every candidate, with share and cost where they were computed.
[[nodiscard]] nlohmann::ordered_json candidates_json(const control::Outcome& outcome);

/// Wanted, reachable and predicted share with its interval, where the partner would have to grasp for the
/// wanted one, and the partner's load beside its limit.
/// The bounds of a lift by the chosen grasp, and whether they are within the limits; null where nothing was
/// chosen.
[[nodiscard]] nlohmann::ordered_json certificate_json(const control::ShareContract& share);
[[nodiscard]] nlohmann::ordered_json share_json(const control::ShareContract& share);

/// The chosen candidate with its share and reason; null when there is none.
[[nodiscard]] nlohmann::ordered_json decision_json(const control::Outcome& outcome);

}  // namespace colift::tools
