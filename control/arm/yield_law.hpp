#pragma once

#include "control/config/monitor_config.hpp"
#include "hal/types/joints.hpp"

namespace colift::control {

/// Where the set point of an arm goes that gives way to a person. The arm is a spring to its set point. A
/// joint that is pushed beyond a band takes the set point along, so that it neither presses harder nor
/// springs back; then the band narrows, so that what remains pressed is pressed lightly. What moves without
/// a push, slowly or for long, is driven by a load that is compensated wrongly: it is not followed.
/// Allocation-free.
class YieldLaw {
 public:
  explicit YieldLaw(const ForceMonitorConfig& config);

  /// A cycle in which nothing unexpected is felt: learns what the springs hold (a load that is not
  /// superposed), which has to be superposed before they become soft.
  void rest(const hal::JointVector& spring_nm, double dt_s);
  [[nodiscard]] const hal::JointVector& held_nm() const { return held_nm_; }

  /// One cycle of a push. `stiffness_nm_rad`: of each joint, as it is commanded now; `pressed`: more than a
  /// limit is felt now. \return Set point (rad).
  [[nodiscard]] hal::JointVector step(const hal::JointVector& q_rad, const hal::JointVector& commanded_rad,
                                      const hal::JointVector& stiffness_nm_rad, bool pressed, double dt_s);

 private:
  double stiffness_nm_rad_, band_rad_, relaxed_band_rad_, relax_s_, rest_s_, max_held_nm_, still_rad_s_,
      swing_s_;
  double left_alone_s_ = 0.0;                             // since it was pressed last
  hal::JointVector last_rad_ = hal::JointVector::Zero();  // measured one cycle ago
  bool last_known_ = false;
  hal::JointVector held_nm_ = hal::JointVector::Zero();
};

}  // namespace colift::control
