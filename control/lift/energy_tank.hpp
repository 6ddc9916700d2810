#pragma once

#include "hal/types/geometry.hpp"

namespace colift::control {

/// How much energy the arm may still put into the object and into whoever holds it. What it gives is observed
/// where it goes over, at the palm: felt wrench times motion; what the world gives back refills the tank. The
/// level is the passivity margin: while it is not below 0 the arm has given no more than it was allowed to,
/// whatever law made its torques. (Passivity observer: Hannaford and Ryu, IEEE T-RA 18, 2002; tank: Duindam
/// and Stramigioli 2004.) Allocation-free.
class EnergyTank {
 public:
  /// Starts to count, with this much allowed (J).
  void fill(double energy_j);
  /// The arm was not commanded for a while: what happened then is not its doing.
  void interrupt() { known_ = false; }
  /// Counts no more.
  void close() { open_ = false; }

  /// One cycle: pose of the palm, and what the environment does to it (about the palm, W).
  void update(const hal::Pose& X_WH, const hal::Wrench& felt_W);

  [[nodiscard]] bool open() const { return open_; }
  [[nodiscard]] double level_j() const { return level_j_; }
  /// Least level since fill().
  [[nodiscard]] double min_level_j() const { return min_level_j_; }
  /// Part of its speed that the set point may rise with: 1, down to 0 over the last `band_j`.
  [[nodiscard]] double speed_scale(double band_j) const;

 private:
  bool open_ = false, known_ = false;
  double level_j_ = 0.0, min_level_j_ = 0.0, full_j_ = 0.0;
  hal::Pose X_WH_ = hal::Pose::Identity();
  hal::Wrench felt_W_;
};

}  // namespace colift::control
