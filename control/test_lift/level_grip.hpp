#pragma once

#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "control/session/decide.hpp"
#include "control/test_lift/test_lift.hpp"

namespace colift::control {

/// Places of the centre of gravity that suit what the belief leaves open (W): nearer to the partner and
/// farther, in the direction that was felt and to either side of it. `partner`: where he holds the object.
[[nodiscard]] std::vector<hal::Vec3> likely_places(const CarriedObject& object, const hal::Vec3& partner,
                                                   const CogBelief& belief);

/// The decision as if the centre of gravity were there (W).
using DecideAt = std::function<hal::Result<Outcome>(const hal::Vec3& cog)>;

/// A decision whose chosen grasp is where test lifts say that the object hangs level.
struct LevelGrip {
  Outcome outcome;
  double chance = 0.0;  ///< That it turns by less than TestLiftConfig::good_turn_deg.
};

/// After test lifts: decides for several places of the centre of gravity that the belief leaves open (nearer
/// to the partner and farther, to either side), and chooses among all grasps that are possible in any of them
/// (next_grip). `partner`: where he holds it (W). `decide` must not refuse for the lever: the belief judges
/// that. nullopt when no grasp is worth a try.
[[nodiscard]] std::optional<LevelGrip> choose_level_grip(const DecideAt& decide, const CarriedObject& object,
                                                         const hal::Vec3& partner,
                                                         std::span<const MeasuredLift> tests,
                                                         const CogBelief& belief, double wanted_share,
                                                         const TestLiftConfig& config);

}  // namespace colift::control
