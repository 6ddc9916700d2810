#pragma once

#include <optional>
#include <span>
#include <string>

#include "control/test_lift/test_lift.hpp"
#include "hal/types/geometry.hpp"
#include "planner/grasp_candidate.hpp"

namespace colift::control {

/// Where the partner should grasp instead, because the robot has no level grip while he holds where he
/// does.
struct PartnerRequest {
  hal::Vec3 position = hal::Vec3::Zero();  ///< W, m.
  hal::Vec3 robot = hal::Vec3::Zero();     ///< Where the robot would grasp first (load point, W).
  double chance = 0.0;                     ///< That one of the robot's grasps is level then.
  double share = 0.0;                      ///< The robot's there, by the mean of the belief.
  std::string reason;                      ///< As a person would say it.
};

/// The place for him from which the robot has the best chance of a level grip: over all places of the centre
/// of gravity that the belief leaves open, the chance that *some* grasp holds it level (chance_level()) while
/// the robot bears a sensible share, because the next test lifts show which; half of it counts for the best
/// single grasp. `places` are all on the object that a hand can grip, whatever the arm makes of them; those
/// that are much higher or lower than `held.front()`, or near to one in `held` (where he is now first, then
/// where he was before) are left out. Of `grasps` those that are possible (Ok or Chosen) count. nullopt where
/// no place has the least chance.
[[nodiscard]] std::optional<PartnerRequest> next_partner_place(
    std::span<const planner::GraspCandidate> places, std::span<const planner::GraspCandidate> grasps,
    std::span<const hal::Vec3> held, const CogBelief& belief, const TestLiftConfig& config);

}  // namespace colift::control
