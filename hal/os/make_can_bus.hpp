#pragma once

#include <memory>
#include <string_view>
#include <vector>

#include "hal/can_bus.hpp"

namespace colift::hal {

/// The bus of a configuration entry: "socketcan:can0" or "socketcand:host:port/can0" (host: a name, an IPv4
/// address, or an IPv6 address in brackets). Not opened yet. Errors: BadConfig, saying what was expected.
[[nodiscard]] Result<std::unique_ptr<CanBus>> make_can_bus(std::string_view text,
                                                           const std::vector<CanFilter>& filters = {});

}  // namespace colift::hal
