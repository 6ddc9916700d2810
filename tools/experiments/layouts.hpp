#pragma once

#include <cstdint>

#include "sim_hal/scenario/scenario.hpp"

namespace colift::experiments {

// Scenes of a trial: the first ones are the shipped scenarios, so that a picture of the campaign shows what
// `colift run` shows; the others are drawn from the seed. Same arguments, same scene.

/// A table and a partner at its far side. 0 and 1: config/scenario/table.yaml and table_pose_2.yaml.
[[nodiscard]] sim_hal::Scenario table_layout(int index, std::uint64_t seed);
/// A long box, the partner on its middle line, so that all grasps over it lie in line with him and the centre
/// of gravity: at the far end (even), where the robot bears half or more, or at a third of the half beyond
/// the centre (odd), where the other end bears less than a third. 0: config/scenario/box.yaml.
[[nodiscard]] sim_hal::Scenario box_in_line(int index, std::uint64_t seed);
/// A box, the partner anywhere at its far end.
[[nodiscard]] sim_hal::Scenario box_layout(int index, std::uint64_t seed);
/// A pipe on two blocks. 0: config/scenario/pipe.yaml.
[[nodiscard]] sim_hal::Scenario pipe_layout(int index, std::uint64_t seed);
/// A chair with its seat towards the robot. 0: config/scenario/chair.yaml.
[[nodiscard]] sim_hal::Scenario chair_layout(int index, std::uint64_t seed);

}  // namespace colift::experiments
