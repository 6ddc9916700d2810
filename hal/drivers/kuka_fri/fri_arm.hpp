#pragma once

#include <memory>
#include <optional>

#include "hal/arm.hpp"
#include "hal/datagram_link.hpp"
#include "hal/drivers/kuka_fri/cart_set_point.hpp"
#include "hal/drivers/kuka_fri/fri_config.hpp"
#include "hal/drivers/kuka_fri/fri_status.hpp"
#include "hal/drivers/kuka_fri/wire/answer_times.hpp"

namespace colift::hal {

/// Cartesian impedance: F = K (X_d - X) + D dX + F_superposed at the tool, in the frames that the KRL program
/// gave to `$STIFFNESS`. Six-vectors go x y z rx ry rz here; the wire's order is made inside.
struct CartesianCommand {
  Pose X = Pose::Identity();                       ///< Tool in base.
  SixVector stiffness = SixVector::Constant(100);  ///< N/m, N m/rad
  SixVector damping_ratio = SixVector::Constant(0.7);
  SixVector wrench = SixVector::Zero();    ///< N, N m
  std::optional<JointVector> posture_rad;  ///< For the null space; needs FriConfig::null_space_posture.
};

/// A KUKA LWR 4+ behind its controller's Fast Research Interface. The controller's datagrams are the clock:
/// wait_cycle() takes one, command() answers it. A cycle that nobody answered is answered by the next
/// wait_cycle() with the last set point; outside of command mode each is answered at once with the
/// controller's own commanded position.
///
/// configure() waits for datagrams, activate() gets command mode (both answer meanwhile and may take as long
/// as FriConfig allows), deactivate() leaves it. The first command after activate(), and after any gap, is
/// the measured pose. Whatever ends command mode stays ended until activate().
///
/// wait_cycle(), command*(), activate(), configure() and deactivate() belong to one thread; stop(), health(),
/// status(), measurement() and answer_times() to any. After configure() a cycle allocates nothing, takes no
/// lock and does no I/O but the link's; its errors therefore are two words, health() has the sentence.
class FriArm final : public Arm {
 public:
  /// The clock has to outlive the arm, and be the link's.
  FriArm(const FriConfig& config, std::unique_ptr<DatagramLink> link, const Clock& clock);
  ~FriArm() override;

  /// Errors: BadConfig (addresses), LinkLost (port in use, nothing comes within first_s).
  Result<> configure() override;
  /// Errors: NotReady (not configured; or why command mode is refused), LinkLost, DeviceFault (drives).
  Result<> activate() override;
  /// Another control strategy ("joint_impedance", "position", "cartesian_impedance"), from the next
  /// activate() on; between configure() and deactivate() the link stays as it is. After the next configure()
  /// it is FriConfig::control again. Errors: NotReady (not configured; the KRC is in command mode; the KRL
  /// program keeps a strategy of its own), BadInput (no such strategy).
  Result<> set_control(const std::string& control);
  /// Comes to rest, asks the KRL program to leave command mode, answers until it has and 100 cycles more.
  void deactivate() noexcept override;
  DeviceHealth health() const override;

  /// Errors: Timeout (no datagram in this cycle), LinkLost (none for silent_s; goes on when they come back),
  /// BadReply (joint positions that cannot be), NotReady (not configured).
  Result<ArmState> wait_cycle() override;
  /// What is commanded now. The thread of wait_cycle().
  [[nodiscard]] FriControl control() const;
  /// In joint impedance control. Errors: NotReady, LimitExceeded (nothing was sent; the cycle is still open).
  Result<> command(const ImpedanceCommand& command) override;
  /// In position control. Errors as command().
  Result<> command_position(const JointVector& q_rad);
  /// In Cartesian impedance control. Errors as command().
  Result<> command_cartesian(const CartesianCommand& command);
  /// The KRC's: joint impedance (30), Cartesian impedance (20) and position control (10); cycles of 1 to 100
  /// ms.
  [[nodiscard]] ArmAbilities abilities() const override;
  void stop() noexcept override;

  /// deactivate(), then makes the KRL program end if FriConfig::end_script, and closes the link.
  void shut_down() noexcept;

  [[nodiscard]] FriStatus status() const;
  /// The last good datagram, all of it.
  [[nodiscard]] FriMeasurement measurement() const;
  /// Estimated wrench on the tool from outside (x y z rx ry rz; N, N m), in `$STIFFNESS.TASKFRAME`, with the
  /// sign of ArmState::tau_external_nm: what the environment does to the arm.
  [[nodiscard]] SixVector external_wrench() const;
  /// What changed since the last call; empty when nothing did. One reading thread.
  [[nodiscard]] std::optional<FriEvent> next_event();
  [[nodiscard]] const AnswerTimes& answer_times() const;
  [[nodiscard]] const FriConfig& config() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// The arm over UDP. Errors: BadConfig (addresses).
[[nodiscard]] Result<std::unique_ptr<FriArm>> make_fri_arm(const FriConfig& config, const Clock& clock);

}  // namespace colift::hal
