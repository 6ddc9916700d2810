#pragma once

#include <memory>

#include "hal/can_log/logged_can_bus.hpp"
#include "hal/drivers/barrett_can/hand_config.hpp"
#include "hal/types/result.hpp"
#include "hal/types/time.hpp"

namespace colift::tools {

/// The hand's bus, and the log that it goes into where one is asked for.
struct LoggedBus {
  std::unique_ptr<hal::CanLogWriter> log;  // in this order: the bus ends before it
  std::unique_ptr<hal::CanBus> bus;
};

/// `announced`: says on the screen where the log is. Errors: BadConfig (no such bus, the log cannot be
/// written).
[[nodiscard]] hal::Result<LoggedBus> make_bus(const hal::BarrettHandConfig& config, const hal::Clock& clock,
                                              bool announced = true);

}  // namespace colift::tools
