#pragma once

#include <cstdint>
#include <memory>
#include <optional>

#include "control/config/config.hpp"
#include "hal/robot_model/robot_model.hpp"
#include "hal/types/result.hpp"
#include "sim_hal/mujoco/sim_world.hpp"
#include "sim_hal/scenario/scenario.hpp"
#include "tools/rig/back_ends.hpp"
#include "tools/rig/robot_file.hpp"

namespace colift::tools {

class EmulatedRig;

/// Devices at the end of a wire, and the emulated far ends of these wires. An interface, so that a program
/// that only simulates (`colift` itself) is built without drivers and emulators.
class WiredDevices {
 public:
  virtual ~WiredDevices() = default;

  /// Another program serves the far ends for the arm's client of this robot.
  [[nodiscard]] virtual bool served_elsewhere(const RobotFile& file) const = 0;
  /// Emulated far ends on a simulated world; also sets `rig.begin`. Errors: BadConfig, what the servers say.
  [[nodiscard]] virtual hal::Result<std::shared_ptr<EmulatedRig>> start_far_ends(
      const RobotFile& file, std::uint64_t seed, const sim_hal::Scenario& scenario,
      std::shared_ptr<sim_hal::SimWorld> world, Rig& rig) const = 0;

  // One device each, not yet behind its guard unless it has one of its own. `far_ends` may be null.
  [[nodiscard]] virtual hal::Result<std::unique_ptr<hal::Arm>> arm(
      const RobotFile& file, const std::shared_ptr<EmulatedRig>& far_ends, Rig& rig) const = 0;
  [[nodiscard]] virtual hal::Result<std::unique_ptr<hal::Hand>> hand(const RobotFile& file) const = 0;
  [[nodiscard]] virtual hal::Result<> camera(const RobotFile& file, const sim_hal::Scenario& scenario,
                                             EmulatedRig* far_ends, bool pose_known,
                                             const control::Config& config, Rig& rig) const = 0;
  /// Those beside the first, each behind its guard, and where they are. Errors also: BadConfig (a camera
  /// without a calibration).
  [[nodiscard]] virtual hal::Result<> more_cameras(const RobotFile& file, const sim_hal::Scenario& scenario,
                                                   EmulatedRig* far_ends, const control::Config& config,
                                                   Rig& rig) const = 0;
};

/// The drivers in hal/drivers and the emulators in sim_hal/emulator.
[[nodiscard]] const WiredDevices& wired_devices();

}  // namespace colift::tools
