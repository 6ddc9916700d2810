#pragma once

#include "hal/types/result.hpp"
#include "sim_hal/mujoco/engine/physics.hpp"
#include "sim_hal/scenario/object_parts.hpp"
#include "sim_hal/scenario/scenario.hpp"

namespace colift::sim_hal {

// Whether a scenario can begin as it is written.

/// Whether a person can grasp the object there (frame T): no more than 3 cm off its surface.
[[nodiscard]] bool on_surface(const ObjectParts& object, const Vec3& p_T);

/// All grasps of the partner lie on the object. Errors: BadConfig with the entry.
[[nodiscard]] hal::Result<> check_grasps(const ScenarioPartner& partner, const ObjectParts& object);

/// Object, robot, floor and clutter stand in each other by no more than 4 mm. Errors: BadConfig with the
/// entry.
[[nodiscard]] hal::Result<> check_overlap(const Overlap& overlap);

}  // namespace colift::sim_hal
