#pragma once

#include "hal/types/joints.hpp"

namespace colift::control {

/// What compensates the load of an arm that yields. A load that is knocked out of the hand would leave a
/// torque behind that raises the soft arm without an end: it fades out when nothing is felt that it holds up,
/// and comes back with the load. Allocation-free.
class YieldCompensation {
 public:
  /// `superposed_nm`: what holds the load; `support_n`: the force up on the palm that this is.
  void start(const hal::JointVector& superposed_nm, double support_n);
  /// Nothing is to be held up any more.
  void drop() { start(hal::JointVector::Zero(), 0.0); }
  /// One cycle. `load_n`: what the hand is felt to carry; `quiet`: no unexpected force is felt, so that this
  /// is the load and nobody's push. \return What to superpose now (N m).
  [[nodiscard]] hal::JointVector step(double load_n, bool quiet, double dt_s);
  /// There was a load, and now there is none.
  [[nodiscard]] bool lost() const { return lost_; }
  /// How much of it is compensated, 0 to 1.
  [[nodiscard]] double part() const { return part_; }

 private:
  hal::JointVector superposed_nm_ = hal::JointVector::Zero();
  double support_n_ = 0.0, part_ = 1.0, changed_s_ = 0.0;
  bool lost_ = false;
};

}  // namespace colift::control
