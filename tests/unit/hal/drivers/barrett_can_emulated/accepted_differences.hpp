#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "tools/bring_up/replay/hand_replay.hpp"

namespace colift {

/// A difference of a kept session that is meant: a line "driver|emulator WORDS # REASON" of NAME.differences.
struct AcceptedDifference {
  bool of_driver = false;  ///< Else of the emulated hand.
  std::string words;       ///< A shell pattern (fnmatch) for the beginning of what replay says.
  std::uint32_t line = 0;  ///< Of the file, from 1.
};

/// Empty lines and those that begin with '#' are passed over. Errors: BadInput with the line, for another
/// side or for words or a reason that are missing.
[[nodiscard]] hal::Result<std::vector<AcceptedDifference>> read_accepted(std::string_view text,
                                                                         const std::string& name);

/// A line for each difference that is not accepted, and for each accepted one that does not occur any more.
/// Empty: the session is as kept. `driver` is unset for a log without calls.
[[nodiscard]] std::string judge_kept(const std::vector<AcceptedDifference>& accepted,
                                     const std::optional<hal::DriverReplay>& driver,
                                     const tools::EmulatorReplay& emulator);

}  // namespace colift
