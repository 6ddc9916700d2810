#pragma once

#include <cstdint>
#include <optional>

#include "hal/types/time.hpp"

namespace colift::hal::kinect {

/// The device's 32-bit counter (60 MHz) as a time that never wraps, and as a time of the robot's clock.
///
/// A frame's time on the robot's clock is the device's time plus the smallest transport time seen lately:
/// late deliveries do not move it, and the drift between both clocks (some 50 ppm) is followed.
class DeviceClock {
 public:
  struct Times {
    Timestamp device{0};   ///< Since the first frame.
    Timestamp exposed{0};  ///< On the robot's clock, without latency.
    Duration late{0};      ///< Beyond the quickest delivery of the last seconds.
  };

  /// `arrived` is the robot's time at which the frame came; it also tells how many times the counter wrapped.
  [[nodiscard]] Times note(std::uint32_t ticks, Timestamp arrived);

  /// For a device that was opened anew.
  void forget() { *this = DeviceClock(); }

 private:
  struct Min {
    Duration offset{0};
    Timestamp since{0};
  };
  std::optional<std::uint32_t> last_ticks_;
  std::int64_t ticks_ = 0;  ///< Unwrapped, from the first.
  Timestamp arrived_{0};
  std::optional<Min> now_, before_;  ///< Smallest offsets of this and of the last window.
};

}  // namespace colift::hal::kinect
