#pragma once

#include <memory>
#include <string>
#include <string_view>

#include "hal/datagram_link.hpp"

namespace colift::hal {

/// Reads "127.0.0.1:49938" or ":49938" (any address). Errors: BadConfig, saying what was expected.
[[nodiscard]] Result<Endpoint> parse_endpoint(std::string_view text);
[[nodiscard]] std::string to_string(const Endpoint& endpoint);

/// A UDP socket bound to `local`. Arrival times are CLOCK_MONOTONIC, taken when receive() returns.
[[nodiscard]] std::unique_ptr<DatagramLink> make_udp_link(const Endpoint& local);

}  // namespace colift::hal
