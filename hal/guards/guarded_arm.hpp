#pragma once

#include <memory>

#include "hal/arm.hpp"
#include "hal/config/range.hpp"
#include "hal/robot_model/robot_model.hpp"
#include "hal/types/time.hpp"

namespace colift::hal {

/// Limits of commands and states at the last gate before the arm.
struct GuardConfig {
  double limit_margin_deg = 1.0;
  double velocity_fraction = 1.0;
  double max_velocity_rad_s = 4.0;
  double acceleration_rad_s2 = 15.0;
  double max_stiffness_nm_rad = 2000.0;
  double max_superposed_nm = 60.0;
  double superposed_slope_nm_s = 200.0;
  double stale_s = 0.05;

  template <class Visitor>
  void visit(Visitor& v) {
    v("limit_margin_deg", limit_margin_deg, Range{0, 20}, "No command comes nearer to a joint limit (deg).");
    v("velocity_fraction", velocity_fraction, kFraction,
      "Velocity scale: fraction of the joints' velocity limits that commands may use.");
    v.renamed("velocity_part", "velocity_fraction");
    v("max_velocity_rad_s", max_velocity_rad_s, kPositive, "Max commanded joint velocity (rad/s).");
    v("acceleration_rad_s2", acceleration_rad_s2, kPositive, "Max acceleration of commands (rad/s^2).");
    v("max_stiffness_nm_rad", max_stiffness_nm_rad, kPositive, "Max joint stiffness (N m/rad).");
    v("max_superposed_nm", max_superposed_nm, kNotNegative, "Max superposed torque (N m).");
    v("superposed_slope_nm_s", superposed_slope_nm_s, kPositive,
      "Fastest change of superposed torque (N m/s).");
    v("stale_s", stale_s, kPositive, "A measured state older than this ends command mode (s).");
  }
};

/// The last gate before the wire: an Arm around an Arm. Every command is checked for NaN, joint limits, step
/// of position and velocity (across gaps and restarts too), stiffness, damping and superposed torque; every
/// state for NaN, staleness, doubled time stamps and steps that no arm can make. A command that breaks a
/// limit is not sent: the inner arm gets a braking one that keeps all limits and comes to rest, and the
/// caller gets LimitExceeded with joint and numbers.
class GuardedArm final : public Arm {
 public:
  GuardedArm(std::unique_ptr<Arm> inner, const RobotModel& model, const GuardConfig& config);
  ~GuardedArm() override;
  Result<> configure() override;
  Result<> activate() override;
  void deactivate() noexcept override;
  DeviceHealth health() const override;
  Result<ArmState> wait_cycle() override;
  Result<> command(const ImpedanceCommand& command) override;
  /// The device's, within the guard's own limits.
  [[nodiscard]] ArmAbilities abilities() const override;
  void stop() noexcept override;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace colift::hal
