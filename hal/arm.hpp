#pragma once

#include "hal/device.hpp"
#include "hal/types/geometry.hpp"
#include "hal/types/joints.hpp"
#include "hal/types/time.hpp"

namespace colift::hal {

/// What the arm's controller measured in one cycle.
struct ArmState {
  Timestamp measured_at{0};
  JointVector q_rad = JointVector::Zero();            ///< Measured joint position.
  JointVector q_commanded_rad = JointVector::Zero();  ///< Joint position that the controller is following.
  JointVector tau_nm = JointVector::Zero();           ///< Measured joint torque.
  JointVector tau_external_nm = JointVector::Zero();  ///< Estimate of the torque from contacts.
  bool may_command = false;                           ///< True while the controller accepts commands.
  bool slow = false;                                  ///< It warns (connection, drives): go on, but slower.
};

/// Joint impedance: tau = K (q_d - q) + D dq + tau_superposed, with the controller's own gravity
/// compensation.
struct ImpedanceCommand {
  JointVector q_rad = JointVector::Zero();
  JointVector stiffness_nm_rad = JointVector::Constant(1000.0);
  JointVector damping_ratio = JointVector::Constant(0.7);
  JointVector tau_superposed_nm = JointVector::Zero();
};

/// A seven-joint arm in joint impedance control.
class Arm : public Device {
 public:
  /// Sleeps until the controller's next cycle; returns what it measured there.
  /// Errors: Timeout (a cycle was missed), LinkLost (the arm has already stopped itself).
  [[nodiscard]] virtual Result<ArmState> wait_cycle() = 0;

  /// Answers that cycle, once, before the next wait_cycle(). Real-time safe.
  /// Errors: LimitExceeded (nothing was sent; the last command holds), NotReady (stopped).
  [[nodiscard]] virtual Result<> command(const ImpedanceCommand& command) = 0;

  /// Brings the arm to rest and holds it until activate(). Any thread, any number of times.
  virtual void stop() noexcept = 0;
};

}  // namespace colift::hal
