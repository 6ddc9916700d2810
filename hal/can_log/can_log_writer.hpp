#pragma once

#include <filesystem>
#include <memory>
#include <string>

#include "hal/can_log/candump.hpp"
#include "hal/types/short_text.hpp"

namespace colift::hal {

/// How large a log may become; what comes after is counted, not written.
struct CanLogLimits {
  std::uint64_t most_bytes = 1ull << 30;
};

/// Writes a bus's frames and notes into a file, in a thread of its own. frame() and note() never wait and
/// allocate nothing: what does not fit into a queue of 4096 is lost, counted, and named by a note in the
/// file. One thread logs at a time. The file is complete when the writer is gone, and up to 0.2 s before when
/// the program dies.
class CanLogWriter {
 public:
  /// Makes the file; one that exists is kept, and a number put into the name of the new one ("hand-2.log").
  /// `interface` as it stands in each line. Times of the log are those of the caller's clock, moved by
  /// `to_wall`. Errors: BadConfig (no such folder, no permission).
  [[nodiscard]] static Result<std::unique_ptr<CanLogWriter>> create(const std::filesystem::path& file,
                                                                    std::string interface, Duration to_wall,
                                                                    const CanLogLimits& limits = {});
  ~CanLogWriter();  ///< Waits until everything is in the file.
  CanLogWriter(const CanLogWriter&) = delete;
  CanLogWriter& operator=(const CanLogWriter&) = delete;

  void frame(const CanFrame& frame, Timestamp at, CandumpFrame::Direction direction) noexcept;
  void note(const ShortText& text, Timestamp at) noexcept;

  /// Waits until all that was logged so far is in the file: for who has no deadline, as a lock-step run.
  void flush();

  [[nodiscard]] const std::filesystem::path& file() const;
  /// Frames and notes that are not in the file, for want of room or because the disk is full. Any thread.
  [[nodiscard]] std::uint64_t lost() const;

 private:
  struct Impl;
  explicit CanLogWriter(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

/// What to add to the machine's monotonic clock for the time of day, as candump writes it.
[[nodiscard]] Duration to_wall_clock();

}  // namespace colift::hal
