#pragma once

#include <optional>
#include <span>
#include <string>

#include "control/session/decide.hpp"

namespace colift::control {

/// Where the partner should rather grasp.
struct Suggestion {
  hal::Vec3 position = hal::Vec3::Zero();  ///< W, m.
  std::optional<double> gain;  ///< Part of the effort of both (eq. 4.5) that it saves, 0 to 1; unset where
                               ///< the robot has no grasp as he stands now.
  std::string reason;          ///< As a person would say it.
};

/// The place for him with which, and with the grasp that the robot would take then, both together need least.
/// His places are all on the object that a hand can grip, about as high as he holds it now, within the arm's
/// reach or not: a person gets around it. `candidates` are those of the look, as judged before a partner was
/// there. nullopt without a partner, where no place saves a tenth (nobody is sent around for less), or where
/// torque costs nothing.
[[nodiscard]] std::optional<Suggestion> suggest_to_partner(
    const Outcome& outcome, std::span<const planner::GraspCandidate> candidates, const hal::Vec3& cog,
    const hal::Vec3& up, const planner::DecisionConfig& config);

}  // namespace colift::control
