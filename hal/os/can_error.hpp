#pragma once

#include <cstdint>
#include <span>

#include "hal/can_bus.hpp"

namespace colift::hal {

/// Enters one error frame of Linux (linux/can/error.h) into a bus's health. `error_class` are the bits of its
/// identifier, `data` its bytes: eight from SocketCAN, none from a gateway that tells the class only. Any
/// bits and bytes may come.
void note_can_error(std::uint32_t error_class, std::span<const std::uint8_t> data,
                    CanHealth& health) noexcept;

}  // namespace colift::hal
