#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace colift::hal::capture {

// What the capture process says on its standard output, a line each that begins with '@':
//   @frame                        a frame is in the ring
//   @state WORD                   opening, streaming
//   @serial TEXT
//   @name TEXT                    maker and model
//   @constants NUMBER...          of the device; what they are is for its driver to know
//   @features WORD...             of: infrared, motor
//   @error WORD TEXT              and ends, unless the word is "request"
//   @finished                     the recording that was asked for is whole
//   @note TEXT
// Anything else is what the library printed. And what it is told on its standard input:
//   infrared on|off, brightness N, tilt DEG, finish, quit; the end of the input is the same as quit.

/// Why the process ended, as it says itself.
enum class CaptureEnd : std::uint8_t {
  NoDevice,
  CannotOpen,
  NoMode,
  CannotStart,
  DeviceLost,
  NoFrames,
  BadCall,
  Request
};
inline constexpr std::array<std::string_view, 8> kCaptureEndWords{
    "no-device", "cannot-open", "no-mode", "cannot-start", "device-lost", "no-frames", "bad-call", "request"};
[[nodiscard]] constexpr std::string_view word(CaptureEnd end) {
  return kCaptureEndWords[static_cast<std::size_t>(end)];
}

/// What a process has said so far, put together from any bytes it may send.
struct CaptureNews {
  std::uint64_t frames = 0;  ///< Lines that told of one.
  std::string serial, name;
  std::vector<double> constants;  ///< Finite, eight at most; empty: not said, or not to be read.
  bool infrared = false, motor = false;
  bool finished = false;
  std::optional<CaptureEnd> end;  ///< Never Request.
  std::string reason;             ///< Of the end.
  std::string refused;            ///< Of the last request that could not be met; empty: none.
  std::string last_words;         ///< The last line that the library printed or that was noted.
  std::uint64_t garbage = 0;      ///< Lines with '@' that mean nothing.
};

/// Cuts a stream of bytes into lines and reads them. Any bytes may come, in any pieces; nothing is kept
/// beyond one line of bounded length.
class CaptureLines {
 public:
  void take(std::string_view bytes, CaptureNews& news);

 private:
  void line(std::string_view text, CaptureNews& news) const;
  std::string rest_;
  bool too_long_ = false;
};

}  // namespace colift::hal::capture
