#pragma once

#include <cstddef>
#include <optional>
#include <span>

#include "hal/drivers/recorded/file_bytes.hpp"

namespace colift::hal {

/// Expands one LZF stream (literal runs up to 32 bytes, back references up to 8 KiB away) to exactly
/// out.size() bytes. Returns the number of bytes of `in` that were used up, or nothing when the stream does
/// not fit.
[[nodiscard]] std::optional<std::size_t> expand_lzf(Bytes in, std::span<std::byte> out);

}  // namespace colift::hal
