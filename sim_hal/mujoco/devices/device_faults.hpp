#pragma once

#include <string_view>

#include "sim_hal/mujoco/sim_world.hpp"

namespace colift::sim_hal {

/// What the scenario does to a device at this moment.
enum class Fault {
  None,
  Drop,     ///< No answer (drop, silent).
  Freeze,   ///< The same answer again, with its old time.
  Late,     ///< Answers come slowly.
  Corrupt,  ///< An answer with a number that is none.
  Unplug,   ///< The device is gone until it is configured anew.
};
[[nodiscard]] Fault fault_now(const SimWorld& world, std::string_view device);

}  // namespace colift::sim_hal
