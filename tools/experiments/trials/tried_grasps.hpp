#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "tools/experiments/trials/direct_lift.hpp"
#include "tools/experiments/trials/sighting.hpp"

namespace colift::experiments {

/// Which of the grasps that the arm reaches are carried out: those in `always` (indices, kept first), then
/// the others, each as far as possible from all before it, until there are `most`. They cover the object as
/// the lettered grasps of the thesis's figures 6.4, 6.7 and 6.10 do.
[[nodiscard]] std::vector<std::size_t> spread_over(const std::vector<planner::GraspCandidate>& candidates,
                                                   const std::vector<bool>& possible,
                                                   const std::vector<std::size_t>& always, std::size_t most);

/// Hand and arm can carry it out, whatever the partner does.
[[nodiscard]] bool is_in_reach(const planner::GraspCandidate& candidate);

/// The `n` cheapest rivals of the chosen grasp, cheapest first.
[[nodiscard]] std::vector<std::size_t> next_best(const control::Outcome& outcome, std::size_t n);

/// Plans a way and lifts. A grasp without a way gives a lift that is not held, with the reason.
[[nodiscard]] DirectLift try_grasp(Observation& observation, const sim_hal::Scenario& scenario,
                                   const planner::GraspCandidate& grasp, const control::Config& config,
                                   std::uint64_t seed, const LiftObserver& eye = {});

/// "a", "b", ..., "z", "aa": names of the grasps of a figure.
[[nodiscard]] std::string letter(std::size_t index);

}  // namespace colift::experiments
