#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "hal/can_bus.hpp"

namespace colift::hal {

/// One frame of a log; `frame.arrived_at` is the line's time.
struct CandumpFrame {
  enum class Direction : std::uint8_t { Unknown, Received, Sent };
  CanFrame frame;
  Direction direction = Direction::Unknown;  ///< Unknown in logs without the letter at a line's end.
  std::uint32_t line = 0;                    ///< From 1.
};

/// A line that begins with '#': `text` is what follows the time, if there is one.
struct CandumpNote {
  Timestamp at{0};  ///< Its own "(seconds)", else that of the frame before it, else 0.
  std::string text;
  std::uint32_t line = 0;
};

struct Candump {
  std::vector<CandumpFrame> frames;  ///< In the order of time; lines of one time in the order of the file.
  std::vector<CandumpNote> notes;    ///< In the order of the file.
  std::uint64_t error_frames = 0;    ///< Of candump -e: counted, not kept.
  std::string interface;             ///< Of the first frame.
};

inline constexpr std::size_t kMostCandumpBytes = 256u << 20;
inline constexpr std::size_t kLongestCandumpLine = 512;

/// A log as `candump -L` writes it, also with -x (direction) and -e (error frames). Nothing is guessed: the
/// first line that is neither a frame with an 11-bit identifier on one interface, nor an error frame, nor a
/// note, nor empty is refused; so are remote and FD frames, times that step back by more than a second, lines
/// over 512 and files over 256 MiB. Times in nanoseconds since the log's own origin. Errors: BadInput,
/// `where` is "NAME:LINE".
[[nodiscard]] Result<Candump> parse_candump(std::string_view text, const std::string& name);

/// The same from a file. Errors: also BadInput (missing, no regular file, too large).
[[nodiscard]] Result<Candump> read_candump(const std::filesystem::path& file);

/// One line with its end, into `buffer` (at least 96 bytes); how long it is.
[[nodiscard]] std::size_t write_candump(std::span<char> buffer, std::string_view interface,
                                        const CanFrame& frame, Timestamp at,
                                        CandumpFrame::Direction direction) noexcept;

/// "(seconds.microseconds)", as a line of the log begins.
[[nodiscard]] std::string candump_time(Timestamp at);

}  // namespace colift::hal
