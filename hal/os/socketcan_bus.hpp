#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "hal/can_bus.hpp"

namespace colift::hal {

/// A raw socket of Linux on a CAN interface. The kernel lets through what passes one of `filters` (everything
/// when there are none), stamps each frame, and reports error frames. open() errors: BadConfig (no such
/// interface, not CAN, another bit rate than `bitrate` where the interface has one), LinkLost (down; no
/// SocketCAN in the kernel; no permission). Arrival times are CLOCK_MONOTONIC.
[[nodiscard]] std::unique_ptr<CanBus> make_socketcan_bus(const std::string& interface,
                                                         const std::vector<CanFilter>& filters = {},
                                                         std::uint32_t bitrate = 1'000'000);

}  // namespace colift::hal
