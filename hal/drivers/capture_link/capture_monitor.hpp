#pragma once

#include <cstdint>
#include <string>

#include "hal/drivers/capture_link/capture_times.hpp"
#include "hal/types/time.hpp"

namespace colift::hal::capture {

/// When a capture process is started, killed and started again: time and what is seen go in, what is to be
/// done comes out.
class CaptureMonitor {
 public:
  enum class Do {
    Nothing,
    Start,
    Kill,
    Abandon,  ///< It does not die: another one is started beside it.
  };
  struct Sight {
    bool exists = false;
    std::uint64_t heartbeat = 0;
    std::uint64_t frames = 0;  ///< In all, since its start.
    bool no_device = false;    ///< It ended, and says that there is none.
    std::string ended;         ///< How it ended; empty while it exists.
  };

  explicit CaptureMonitor(const CaptureTimes& times) : times_(times) {}

  [[nodiscard]] Do look(const Sight& sight, Timestamp now);

  /// Starts at once, whatever pause there was.
  void want();
  /// Nothing is started any more.
  void rest();

  [[nodiscard]] bool running() const { return phase_ == Phase::Running; }
  [[nodiscard]] bool resting() const { return phase_ == Phase::Resting; }
  /// When the newest frame was noticed, or the process was started.
  [[nodiscard]] Timestamp frame_seen_at() const { return frame_at_; }
  /// Why it is not running, or was ended last; empty: never.
  [[nodiscard]] const std::string& why() const { return why_; }
  [[nodiscard]] std::uint64_t starts() const { return starts_; }
  [[nodiscard]] std::uint64_t kills() const { return kills_; }

 private:
  enum class Phase { Resting, Running, Dying, Pausing };
  [[nodiscard]] std::string overdue(Timestamp now) const;
  void pause(const Sight& sight, Timestamp now);

  CaptureTimes times_;
  Phase phase_ = Phase::Resting;
  Timestamp since_{0}, beat_at_{0}, frame_at_{0}, until_{0};
  std::uint64_t heartbeat_ = 0, frames_ = 0, starts_ = 0, kills_ = 0;
  double pause_s_ = 0.0;
  std::string why_;
};

}  // namespace colift::hal::capture
