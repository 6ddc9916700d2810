#pragma once

#include <cstddef>
#include <string>

#include "tools/telemetry/mcap/mcap_reader.hpp"

namespace colift::telemetry {

/// Largest document that a page is given (bytes).
inline constexpr std::size_t kLargestPageRecording = 64u << 20;

/// A recording for the page, which pauses, searches and steps through it by itself: lines
/// "TOPIC NANOSECONDS JSON" by the recording's clock, in the order of the file. What comes often is thinned
/// to what a page draws, and further until all of it fits into `largest` bytes; changes of state, decisions,
/// plans and words are kept. What still does not fit is left out from the end.
[[nodiscard]] std::string page_recording(const McapReader& file, std::size_t largest = kLargestPageRecording);

}  // namespace colift::telemetry
