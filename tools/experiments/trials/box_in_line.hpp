#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "sim_hal/scenario/scenario.hpp"

namespace colift::experiments {

// A long box with the partner on its middle line (thesis figure 6.10): all grasps over it lie in line with
// him and the centre of gravity, so that a grasp's place alone says how the load is shared. By the lever rule
// the robot bears x1 / (x1 + x2), where x1 and x2 are the distances of the partner and of the robot from the
// centre of gravity.

/// A box, its partner, and its pose such that the place where the robot would bear `share` (over 0, below 1)
/// is on the box, within the arm's reach and clear of the partner. Same arguments, same scene.
/// 0: config/scenario/box.yaml, whatever the share.
[[nodiscard]] sim_hal::Scenario box_in_line(int index, std::uint64_t seed, double share);

/// Why nobody could bear `share` of that box against its partner, by its true size, mass and pose: the place
/// is beyond the box's end, under the partner's hands, or out of the arm's reach. Nothing if it can be borne.
[[nodiscard]] std::optional<std::string> share_forbidden(const sim_hal::Scenario& box, double share);

}  // namespace colift::experiments
