#pragma once

#include <cstdint>
#include <optional>

#include "hal/drivers/capture_link/transport_delay.hpp"
#include "hal/types/time.hpp"

namespace colift::hal::kinect {

/// The device's 32-bit counter (60 MHz) as a time that never wraps, and as a time of the robot's clock.
class DeviceClock {
 public:
  using Times = capture::TransportDelay::Times;  ///< The device's time is since the first frame.

  /// `arrived` is the robot's time at which the frame came; it also tells how many times the counter wrapped.
  [[nodiscard]] Times note(std::uint32_t ticks, Timestamp arrived);

  /// For a device that was opened anew.
  void forget() { *this = DeviceClock(); }

 private:
  std::optional<std::uint32_t> last_ticks_;
  std::int64_t ticks_ = 0;  ///< Unwrapped, from the first.
  Timestamp arrived_{0};
  capture::TransportDelay delay_;
};

}  // namespace colift::hal::kinect
