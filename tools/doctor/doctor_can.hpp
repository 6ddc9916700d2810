#pragma once

#include <functional>
#include <string>

#include "hal/os/can_link.hpp"
#include "tools/doctor/doctor_row.hpp"

namespace colift::tools {

using AskCanLink = std::function<hal::Result<hal::CanLink>(const std::string& interface)>;

/// The hand's bus as configured ("socketcan:can0" or a gateway), and every CAN interface with its link, bit
/// rate, error counters and restart time. `ask` is hal::read_can_link on the machine.
[[nodiscard]] DoctorRows can_rows(const std::filesystem::path& root, const std::string& hand_bus,
                                  const AskCanLink& ask);

}  // namespace colift::tools
