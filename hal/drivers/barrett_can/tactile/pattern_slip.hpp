#pragma once

#include <array>

#include "hal/hand.hpp"

namespace colift::hal::barrett {

struct PatternLimits {
  double moved_mm = 4.0;   ///< Of a pad's centre of pressure from where it was lately; rows are 6 mm apart.
  double min_n_cm2 = 0.3;  ///< Sum over a pad's cells below which there is no pattern.
  double follows_s = 0.5;  ///< Slow changes are the load's.
};

/// Slip from the patterns on the fingertips. An object presses on at least two pads, and moves on all of them
/// at once: a single pad that jumps is a broken cell or a finger that settles. One scan of each is enough, so
/// the alarm comes with the second pad's scan, within 50 ms of a scan every 25 ms. What does not change the
/// pattern, a smooth plane that slides, is not seen.
class PatternSlip {
 public:
  explicit PatternSlip(const PatternLimits& limits = {}) : limits_(limits) {}

  /// The pattern as it is now is a good one; forgets an alarm.
  void start() { *this = PatternSlip(limits_); }

  /// The newest scans; a scan that was there before counts once. Only fingers in `holding` count.
  void add(const std::array<TactileArray, kFingers>& pads, const std::array<bool, kFingers>& holding);

  [[nodiscard]] bool slipped() const { return slipped_; }

 private:
  struct Pad {
    Timestamp at{0};
    double along_mm = 0.0, across_mm = 0.0;  ///< Reference of the centre.
    bool known = false, moved = false;
  };
  PatternLimits limits_;
  std::array<Pad, kFingers> pads_{};
  bool slipped_ = false;
};

}  // namespace colift::hal::barrett
