#pragma once

#include <cstdint>
#include <string_view>

#include "hal/types/result.hpp"
#include "tools/telemetry/channels/recorded_frame.hpp"

namespace colift::telemetry {

// Depth frames of old recordings: one message with everything in it, in a form of our own
// (docs/telemetry.md). Read only.

/// Whether a message of /camera/depth is of this form.
[[nodiscard]] bool is_cdt1(std::string_view bytes);

/// Lossless to the bit, NaNs included. Errors: BadInput (damaged; a frame of no or more than 8192 x 8192
/// pixels).
[[nodiscard]] hal::Result<NumberedFrame> decode_cdt1(std::string_view bytes);

/// Only the frame's number. Errors: BadInput.
[[nodiscard]] hal::Result<std::uint64_t> cdt1_number(std::string_view bytes);

}  // namespace colift::telemetry
