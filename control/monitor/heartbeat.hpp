#pragma once

#include <atomic>
#include <cstdint>

#include "hal/types/time.hpp"

namespace colift::control {

/// A sign of life: a thread counts its cycles, others see whether the count goes on. Wait-free on both sides.
class Heartbeat {
 public:
  void beat() noexcept { count_.fetch_add(1, std::memory_order_relaxed); }
  [[nodiscard]] std::uint64_t count() const noexcept { return count_.load(std::memory_order_relaxed); }

 private:
  std::atomic<std::uint64_t> count_{0};
};

/// For how long a heartbeat has been missing, as its observer sees it: time in which the observer did not run
/// either counts for one step of kMaxStep only, so that a machine that stood still accuses nobody.
/// Allocation-free; one thread.
class BeatMonitor {
 public:
  static constexpr hal::Duration kMaxStep = std::chrono::milliseconds(20);

  /// Once in each cycle of the observer: the other's count, and the time of the observer's clock. Returns
  /// silent_s().
  double update(std::uint64_t count, hal::Timestamp now) noexcept;
  /// Time without a beat until the last update() (s).
  [[nodiscard]] double silent_s() const noexcept { return hal::seconds(silent_); }

 private:
  std::uint64_t count_ = 0;
  hal::Timestamp updated_at_{0};
  hal::Duration silent_{0};
  bool begun_ = false;
};

}  // namespace colift::control
