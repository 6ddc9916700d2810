#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "hal/can_bus.hpp"

namespace colift::hal {

/// The bus of a socketcand gateway over TCP: python-can and Debian's can-utils world speak the same protocol.
/// open() connects and shakes hands within 2 s in all (a name that has to be looked up may take the
/// resolver's time on top). Errors: LinkLost (nobody there, silent, closed), BadConfig (the gateway has no
/// such bus, does not speak socketcand). The gateway tells the class of error frames but not their bytes; its
/// own queue is not seen. Frames are filtered here. Arrival times are CLOCK_MONOTONIC of this machine.
[[nodiscard]] std::unique_ptr<CanBus> make_socketcand_bus(const std::string& host, std::uint16_t port,
                                                          const std::string& bus,
                                                          const std::vector<CanFilter>& filters = {});

}  // namespace colift::hal
