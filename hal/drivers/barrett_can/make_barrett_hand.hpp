#pragma once

#include <memory>

#include "hal/can_bus.hpp"
#include "hal/can_log/can_log_writer.hpp"
#include "hal/drivers/barrett_can/hand_config.hpp"
#include "hal/hand.hpp"

namespace colift::hal {

/// A BarrettHand that owns its bus and runs in a thread of its own (HandThread), on the machine's steady
/// clock. The bus need not be open: configure() opens it. With a log every frame, every call and the settings
/// are in it.
[[nodiscard]] std::unique_ptr<Hand> make_barrett_hand(std::unique_ptr<CanBus> bus,
                                                      const BarrettHandConfig& config,
                                                      std::unique_ptr<CanLogWriter> log = nullptr);

/// The log that `config.bus_log` asks for; null when it asks for none. Errors: BadConfig (no such folder, no
/// permission).
[[nodiscard]] Result<std::unique_ptr<CanLogWriter>> make_bus_log(const BarrettHandConfig& config);

}  // namespace colift::hal
