#pragma once

#include <string>
#include <vector>

#include "control/test_lift.hpp"
#include "tools/experiments/tried_grasps.hpp"

namespace colift::experiments {

/// One test lift of a search for a level grip.
struct TriedGrip {
  planner::GraspCandidate grasp;
  double chance = NAN;  ///< That it would be level, before it was tried; unset for the first one.
  DirectLift lift;      ///< Of a few millimetres.
  double drift_rad_s = 0.0;
  std::optional<control::TestLift> known;
  std::string because;  ///< What was learnt, or why nothing was.
};

struct GripSearch {
  std::vector<TriedGrip> tried;           ///< At least one.
  std::optional<std::size_t> level = {};  ///< The one that may be lifted.
  std::string because;
};

/// Test lifts, beginning with `first`: takes hold, raises slowly until the camera has seen enough, puts down;
/// takes hold elsewhere (control::next_grip) as long as the object turns. When no grip is good, the least
/// tilted of the bearable ones is. Each in a world of its own, where the object stands as it stood.
/// `share_predicted` belongs to `first`; `config` is the decision's.
[[nodiscard]] GripSearch search_level_grip(Sighting& sighting, const sim_hal::Scenario& scenario,
                                           const planner::GraspCandidate& first, double share_predicted,
                                           const control::Config& config,
                                           const control::TestLiftConfig& test_config, std::uint64_t seed);

}  // namespace colift::experiments
