#pragma once

#include <cstdint>

/// How often operator new was called in this program.
[[nodiscard]] std::uint64_t allocations();
