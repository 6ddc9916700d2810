#pragma once

#include "hal/types/joints.hpp"

namespace colift::control {

/// How much energy the arm may still put into the object and into whoever holds it. An arm whose set point
/// stands still is passive; what moves the set point, feeds a load forward or stiffens the springs is active
/// and comes out of this tank, and what the world gives back refills it. The level is the passivity margin:
/// as long as it is not below 0 the arm has given no more than it was allowed to. (Duindam and Stramigioli
/// 2004; Schindlbeck and Haddadin, ICRA 2015.) Dissipation in the controller is not counted: the true margin
/// is larger. Allocation-free.
class EnergyTank {
 public:
  /// Starts to count, with this much allowed (J).
  void fill(double energy_j);
  /// The arm was not commanded for a while: what happened then is not its doing.
  void interrupt() { known_ = false; }
  /// Counts no more.
  void close() { open_ = false; }

  /// One cycle: measured position, the torque that is commanded there, and what the springs have stored (J).
  void update(const hal::JointVector& q_rad, const hal::JointVector& torque_nm, double stored_j);

  [[nodiscard]] double level_j() const { return level_j_; }
  /// Least level since fill(); with fill()'s, how much was used at most.
  [[nodiscard]] double min_level_j() const { return min_level_j_; }
  [[nodiscard]] bool open() const { return open_; }
  /// Part of its speed that the set point may move away with: 1, down to 0 over the last `band_j`.
  [[nodiscard]] double speed_scale(double band_j) const;

 private:
  bool open_ = false, known_ = false;
  double level_j_ = 0.0, min_level_j_ = 0.0, full_j_ = 0.0, stored_j_ = 0.0;
  hal::JointVector q_rad_ = hal::JointVector::Zero(), torque_nm_ = hal::JointVector::Zero();
};

}  // namespace colift::control
