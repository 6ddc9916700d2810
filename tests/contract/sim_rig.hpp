#pragma once

#include <memory>

#include "sim_hal/mujoco/devices/sim_devices.hpp"
#include "sim_hal/mujoco/sim_world.hpp"

namespace colift {

/// Where the arm of the simulated rigs starts: the palm looks straight ahead.
inline hal::JointVector palm_ahead_rad() {
  hal::JointVector q = sim_hal::SimConfig::home_rad();
  q[5] = -0.17;
  return q;
}

/// A world with the arm at palm_ahead_rad(). With a post, a slim box stands between the fingers; else it
/// stands out of reach.
inline std::unique_ptr<sim_hal::SimWorld> contract_world(bool post_in_hand) {
  const hal::Vec3 palm = hal::hand_pose(hal::built_in_robot(), palm_ahead_rad()).translation();
  sim_hal::Scenario scenario;
  scenario.object.kind = "box";
  scenario.object.size = {0.05, 0.06, palm.z() + 0.15};
  scenario.object.mass = 2.0;
  scenario.object.xyz = {palm.x() + (post_in_hand ? 0.10 : 0.80), palm.y(), 0.0};
  scenario.partner.kind = "none";
  sim_hal::SimConfig config;
  config.start_rad = palm_ahead_rad();
  return sim_hal::SimWorld::make(scenario, hal::built_in_robot(), 1, config).value();
}

}  // namespace colift
