#pragma once

#include "hal/arm.hpp"

namespace colift::sim_hal {

/// Joint impedance as the KRC computes it at 1 kHz between two commands of the client:
/// tau = K (q_d - q) - D dq + tau_superposed + gravity and Coriolis terms, each joint within its effort.
/// q_d moves in a straight line to a new command within one period of the client. The maker does not publish
/// how the damping ratio becomes a damping; here D = 2 d sqrt(K m), m the joint's own entry of the mass
/// matrix.
class ArmControl {
 public:
  ArmControl(const hal::JointVector& start_rad, const hal::JointVector& effort_nm);

  /// A new set point that is reached after `ticks` steps.
  void command(const hal::ImpedanceCommand& command, int ticks);

  /// The set point stays where it is now. The superposed torque turns into an offset of the set point, so
  /// that a loaded arm does not sag.
  void hold();

  /// One step of 1 ms: motor torque.
  /// \param bias_nm  Gravity, Coriolis and centrifugal torque of arm and hand without any load.
  /// \param inertia  Diagonal of the mass matrix (kg m^2).
  [[nodiscard]] hal::JointVector tick(const hal::JointVector& q_rad, const hal::JointVector& dq_rad_s,
                                      const hal::JointVector& bias_nm, const hal::JointVector& inertia);

  [[nodiscard]] const hal::JointVector& set_point_rad() const { return set_point_rad_; }
  /// The command in force; its position is reached step by step (set_point_rad()).
  [[nodiscard]] const hal::ImpedanceCommand& active() const { return command_; }
  [[nodiscard]] const hal::JointVector& torque_nm() const { return torque_nm_; }

 private:
  hal::ImpedanceCommand command_;
  hal::JointVector effort_nm_, set_point_rad_, step_rad_ = hal::JointVector::Zero(),
                                               torque_nm_ = hal::JointVector::Zero();
  int ticks_left_ = 0;
};

}  // namespace colift::sim_hal
