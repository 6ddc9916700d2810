#pragma once

#include <optional>
#include <string>

#include "hal/robot_model/robot_model.hpp"
#include "sim_hal/scenario/object_parts.hpp"
#include "sim_hal/scenario/scenario.hpp"

namespace colift::sim_hal {

/// A block that takes the partner's place (thesis 6.3.1), standing on the floor at its final place.
struct SupportBlock {
  Vec3 center_W = Vec3::Zero();
  Vec3 size = Vec3::Zero();
  double yaw_rad = 0.0;
};

/// Names of bodies in the generated model. Link i of the robot is body "Li", its joint "Ji".
inline constexpr const char* kObjectBody = "object";
inline constexpr const char* kSupportBody = "support";
/// Of a piece of clutter that moves; one that does not belongs to the world.
[[nodiscard]] std::string clutter_body(std::size_t index);

/// The scene as MuJoCo's XML (MJCF): floor, clutter, robot with the
/// joints' inertia, object as one free body, support block (waits far below the floor as a mocap body). No
/// actuators: the world computes the drives' torques itself. Nothing but contact ties robot and object.
[[nodiscard]] std::string mjcf(const Scenario& scenario, const hal::RobotModel& model,
                               const ObjectParts& object, const std::optional<SupportBlock>& support);

}  // namespace colift::sim_hal
