#pragma once

#include <string>

#include "hal/drivers/barrett_can/replay/recorded_pucks.hpp"

namespace colift::hal {

struct DriverReplay : barrett::ReplayFindings {
  std::uint64_t calls = 0;
  double recorded_s = 0.0;  ///< How long the session was.
  [[nodiscard]] bool equal() const { return differences.empty(); }
};

/// Calls today's driver as the log says it was called then, with the settings and the clock of then, and lets
/// the log answer. No time passes but the log's. Errors: BadInput (notes that are not readable; over a day
/// long), NotFound (a log without calls, as candump alone makes it).
[[nodiscard]] Result<DriverReplay> replay_driver(const Candump& log, const std::string& name);

}  // namespace colift::hal
