#pragma once

#include <memory>
#include <string>

#include "hal/drivers/kuka_fri/fri_arm.hpp"
#include "hal/robot_model/dynamics.hpp"

namespace colift::tools {

/// The arm in any of its control strategies behind the interface of a task that commands joints. In position
/// control their positions go out, stiffness and torque do not; in Cartesian impedance the frame that these
/// joints give to the KRC's tool, with the stiffness of FriConfig. That frame is in the KRC's base, which has
/// to be the arm's root there (`$STIFFNESS.BASE` = `$NULLFRAME`, as colift.src has it).
class ControlArm final : public hal::Arm {
 public:
  /// \param model  Has to outlive the arm.
  ControlArm(std::unique_ptr<hal::FriArm> fri, const hal::RobotModel& model);

  /// From the next activate() on.
  void use(std::string control) { control_ = std::move(control); }
  [[nodiscard]] hal::FriArm& fri() { return *fri_; }

  hal::Result<> configure() override { return fri_->configure(); }
  /// Sets the strategy, then gets command mode. Errors: those of set_control() and activate().
  hal::Result<> activate() override;
  void deactivate() noexcept override { fri_->deactivate(); }
  hal::DeviceHealth health() const override { return fri_->health(); }
  hal::Result<hal::ArmState> wait_cycle() override;
  hal::Result<> command(const hal::ImpedanceCommand& command) override;
  [[nodiscard]] hal::ArmAbilities abilities() const override { return fri_->abilities(); }
  void stop() noexcept override { fri_->stop(); }

 private:
  std::unique_ptr<hal::FriArm> fri_;
  hal::ArmDynamics dynamics_;
  std::string control_;
  hal::JointVector measured_rad_ = hal::JointVector::Zero();
};

}  // namespace colift::tools
