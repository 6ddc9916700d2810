#pragma once

#include <memory>

#include "sim_hal/mujoco/sim_world.hpp"
#include "tools/rig/back_ends.hpp"

namespace colift::tools {

/// What a simulated world knows beyond its devices, and its judge. Keeps the world. `in_step`: whoever waits
/// for a device moves the world; else it lives in real time. Before the world moves.
[[nodiscard]] RigTruth truth_of(const std::shared_ptr<sim_hal::SimWorld>& world,
                                const std::shared_ptr<const hal::RobotModel>& model, bool in_step);

}  // namespace colift::tools
