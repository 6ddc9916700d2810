#pragma once

#include <cstdint>
#include <optional>

#include "hal/drivers/capture_link/transport_delay.hpp"
#include "hal/types/result.hpp"
#include "hal/types/time.hpp"

namespace colift::hal::openni2 {

/// Lets frames through that can be new, by the device's count and time stamp; and gives their time on the
/// robot's clock.
///
/// The device's clock runs as fast as the robot's. A frame whose stamp steps by more than a second more or
/// less than time passed is dropped: it waited somewhere, or the device's clock was set. It was set when such
/// frames agree among themselves for 0.3 s, which frames that waited do not: those come faster than they were
/// taken.
class FrameGate {
 public:
  using Times = capture::TransportDelay::Times;
  struct Counts {
    std::uint64_t duplicate = 0;  ///< Had the number of the frame before.
    std::uint64_t old = 0;        ///< Not newer than the frame before.
    std::uint64_t misdated = 0;   ///< A stamp that does not fit the time at which it came.
    std::uint64_t skipped = 0;    ///< Numbers that the device never gave.
    std::uint64_t clock_set = 0;  ///< How often the device's clock was set.
  };

  /// `index` counts the device's frames, `stamp_us` is its clock, `arrived` the robot's time at which the
  /// frame came, `unread` how many came since the call before and were not read. Errors: BadReply, with the
  /// figure.
  [[nodiscard]] Result<Times> pass(std::uint64_t index, std::uint64_t stamp_us, Timestamp arrived,
                                   std::uint64_t unread = 0);

  /// For a device that was opened anew. The counts stay.
  void forget();
  [[nodiscard]] const Counts& counts() const { return counts_; }

 private:
  struct Seen {
    std::uint64_t index = 0;
    Timestamp stamp{0}, arrived{0};
  };
  [[nodiscard]] Times accept(const Seen& frame);

  Counts counts_;
  capture::TransportDelay delay_;
  std::optional<std::uint64_t> index_;  ///< The largest since the last that was let through.
  std::optional<Seen> last_;            ///< That was let through.
  std::optional<Seen> set_since_;       ///< The first of those that agree on another time.
  std::optional<Timestamp> exposed_;
};

}  // namespace colift::hal::openni2
