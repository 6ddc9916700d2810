#pragma once

#include <cstdint>

#include "sim_hal/scenario/scenario.hpp"
#include "tools/experiments/experiment.hpp"

namespace colift::experiments {

// Scenes of a trial: the first ones are the shipped scenarios, so that a picture of the campaign shows what
// `colift run` shows; the others are drawn from the seed. Same arguments, same scene.

/// A table and a partner at its far side. 0 and 1: config/scenario/table.yaml and table_pose_2.yaml.
[[nodiscard]] sim_hal::Scenario table_layout(int index, std::uint64_t seed);
/// config/scenario/box.yaml: the partner holds the far end, on the middle line.
[[nodiscard]] sim_hal::Scenario shipped_box();
/// A box, the partner anywhere at its far end.
[[nodiscard]] sim_hal::Scenario box_layout(int index, std::uint64_t seed);
/// A pipe on two blocks. 0: config/scenario/pipe.yaml.
[[nodiscard]] sim_hal::Scenario pipe_layout(int index, std::uint64_t seed);
/// A chair with its seat towards the robot. 0: config/scenario/chair.yaml.
[[nodiscard]] sim_hal::Scenario chair_layout(int index, std::uint64_t seed);
/// Tables, boxes, pipes and chairs in turn.
[[nodiscard]] sim_hal::Scenario mixed_layout(int index, std::uint64_t seed);

/// The same scene, seen from there.
[[nodiscard]] sim_hal::Scenario seen_from(View view, sim_hal::Scenario scenario);

}  // namespace colift::experiments
