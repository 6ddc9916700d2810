#pragma once

#include <memory>

#include "hal/can_bus.hpp"
#include "hal/drivers/barrett_can/hand_config.hpp"
#include "hal/hand.hpp"

namespace colift::hal {

/// A BarrettHand that owns its bus and runs in a thread of its own (HandThread), on the machine's steady
/// clock. The bus need not be open: configure() opens it.
[[nodiscard]] std::unique_ptr<Hand> make_barrett_hand(std::unique_ptr<CanBus> bus,
                                                      const BarrettHandConfig& config);

}  // namespace colift::hal
