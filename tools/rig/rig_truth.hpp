#pragma once

#include <memory>

#include "sim_hal/mujoco/sim_world.hpp"
#include "tools/rig/back_ends.hpp"

namespace colift::tools {

/// What a simulated world knows beyond its devices. Keeps the world.
[[nodiscard]] RigTruth truth_of(const std::shared_ptr<sim_hal::SimWorld>& world,
                                const std::shared_ptr<const hal::RobotModel>& model);

}  // namespace colift::tools
