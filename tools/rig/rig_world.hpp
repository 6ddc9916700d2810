#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include "hal/robot_model/robot_model.hpp"
#include "hal/types/result.hpp"
#include "sim_hal/mujoco/sim_world.hpp"
#include "sim_hal/scenario/scenario.hpp"
#include "tools/rig/robot_file.hpp"

namespace colift::tools {

/// Unset: the built-in table; kClearedFloor: nothing near the arm. Errors: BadConfig with file:line:column.
[[nodiscard]] hal::Result<sim_hal::Scenario> read_scenario(const std::optional<std::filesystem::path>& file);

/// A scenario for a far end that no task tells its state: one with times relative to it is refused. Errors:
/// BadConfig with the entry.
[[nodiscard]] hal::Result<sim_hal::Scenario> read_absolute_scenario(
    const std::optional<std::filesystem::path>& file);

/// Empty: the built-in LWR 4+ with BarrettHand. Errors: BadConfig with the place.
[[nodiscard]] hal::Result<std::shared_ptr<const hal::RobotModel>> read_model(const std::string& file);

/// The scenario's world, whose arm has the period that the robot's file says. Errors: those of
/// SimWorld::make.
[[nodiscard]] hal::Result<std::shared_ptr<sim_hal::SimWorld>> make_world(const RobotFile& file,
                                                                         const sim_hal::Scenario& scenario,
                                                                         const hal::RobotModel& model,
                                                                         std::uint64_t seed);

}  // namespace colift::tools
