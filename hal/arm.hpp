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

/// What an arm's controller can do, for whoever chooses a control law.
struct ArmAbilities {
  bool joint_impedance = true;
  bool superposed_torque = true;  ///< Beside the joints' impedance; with stiffness 0 that is torque control.
  bool cartesian_impedance = false, position = false;  ///< In the controller, by the driver's own calls.
  double min_period_s = 0.001, max_period_s = 0.1;     ///< Of its cycle.
  double max_stiffness_nm_rad = 2000.0;
  JointVector max_superposed_nm = JointVector::Constant(200.0);
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

  /// Does not change while the arm is configured.
  [[nodiscard]] virtual ArmAbilities abilities() const { return {}; }

  /// Brings the arm to rest and holds it until activate(). Any thread, any number of times.
  virtual void stop() noexcept = 0;
};

}  // namespace colift::hal
