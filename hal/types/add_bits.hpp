#pragma once

#include <cstdint>

namespace colift::hal {

/// to[i] |= from[i] for n bytes that do not overlap.
void add_bits(const std::uint8_t* from, int n, std::uint8_t* to);

}  // namespace colift::hal
