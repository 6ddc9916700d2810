#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "hal/can_bus.hpp"

namespace colift::hal {

/// What the kernel reports of a CAN interface.
struct CanLink {
  int index = 0;  ///< 0: there is no interface of that name.
  bool is_can = false;
  bool up = false;                          ///< Set up by an administrator.
  bool running = false;                     ///< Has a carrier: not bus-off, plugged in.
  std::string kind;                         ///< "can" for hardware, "vcan", "vxcan"; empty when not reported.
  std::optional<CanHealth::State> state;    ///< Of the controller; these only from hardware.
  std::optional<std::uint32_t> bitrate;     ///< Bits per second.
  std::optional<double> sample_point;       ///< As a fraction of the bit.
  std::optional<std::uint32_t> restart_ms;  ///< 0: never restarts by itself after bus-off.
  std::optional<std::uint16_t> send_errors, receive_errors;
};

/// Asks the kernel over netlink. Errors: LinkLost when it does not answer at all; a missing interface is
/// none.
[[nodiscard]] Result<CanLink> read_can_link(const std::string& interface);

/// Why the hand's bus cannot be used over this interface, with the command that mends it.
[[nodiscard]] Result<> check_can_link(const std::string& interface, const CanLink& link,
                                      std::uint32_t bitrate);

}  // namespace colift::hal
