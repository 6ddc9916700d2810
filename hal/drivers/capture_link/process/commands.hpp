#pragma once

#include <charconv>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "hal/drivers/capture_link/frame_ring.hpp"

namespace colift::capture {

/// Lines from the controller. Its thread also ends the process when the controller is gone, even while the
/// library hangs.
class Commands {
 public:
  /// Once; lives as long as the process.
  void listen();
  /// What has come since. "quit" when there will be no more.
  [[nodiscard]] std::vector<std::string> take();

 private:
  void run();
  std::mutex mutex_;
  std::vector<std::string> lines_;
};

/// The number that stands behind `name` until the end of the line; nothing when something else does.
template <class Number>
std::optional<Number> number_after(std::string_view line, std::string_view name) {
  if (!line.starts_with(name)) return std::nullopt;
  line.remove_prefix(name.size());
  Number value{};
  const auto [end, error] = std::from_chars(line.data(), line.data() + line.size(), value);
  if (error != std::errc{} || end != line.data() + line.size()) return std::nullopt;
  return value;
}

/// What a capture process begins with: output that never waits, a priority, the controller's memory as file
/// `fd`. Errors: BadInput (no such memory), which has been said.
[[nodiscard]] hal::Result<hal::capture::FrameRingWriter> begin_capture(int fd);

}  // namespace colift::capture
