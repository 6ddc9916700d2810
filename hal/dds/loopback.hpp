#pragma once

#include "hal/types/result.hpp"

namespace colift::hal::dds {

/// Cyclone DDS binds its receiving sockets to every address, whichever interface its settings name. This ties
/// those of `domain` in this process to the loopback device, so that the kernel hands them nothing from other
/// machines. Errors: DeviceFault where the kernel refuses (before 5.7 it needs CAP_NET_RAW), or no such
/// socket is there.
[[nodiscard]] Result<> tie_to_loopback(int domain);

}  // namespace colift::hal::dds
