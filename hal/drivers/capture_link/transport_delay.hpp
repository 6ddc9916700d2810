#pragma once

#include <optional>

#include "hal/types/time.hpp"

namespace colift::hal::capture {

/// A device's own time as one of the robot's clock: the device's plus the smallest transport time seen
/// lately. Late deliveries do not move it, and the drift between both clocks (some 50 ppm) is followed.
class TransportDelay {
 public:
  struct Times {
    Timestamp device{0};   ///< As it was given.
    Timestamp exposed{0};  ///< On the robot's clock, without latency.
    Duration late{0};      ///< Beyond the quickest delivery of the last seconds.
  };

  /// `device` never wraps; `arrived` is the robot's time at which the frame came.
  [[nodiscard]] Times note(Timestamp device, Timestamp arrived);

 private:
  struct Min {
    Duration offset{0};
    Timestamp since{0};
  };
  std::optional<Min> now_, before_;  ///< Smallest offsets of this and of the last window.
};

}  // namespace colift::hal::capture
