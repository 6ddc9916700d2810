#pragma once

#include <memory>

#include "sim_hal/emulator/krc/plant/krc_plant.hpp"
#include "sim_hal/mujoco/sim_world.hpp"

namespace colift::sim_hal {

/// The arm of a simulated world under the KRC's law: what the arm touches, it feels. Moves the world's time:
/// nobody else may. Its cycle is the world's arm_period. Position control is the stiffest joint impedance
/// that the KRC has; Cartesian impedance is computed here, at 1 kHz, as superposed torque.
class KrcWorldPlant final : public KrcPlant {
 public:
  /// The world has to outlive the plant; `dynamics` is of its model, with the hand.
  KrcWorldPlant(SimWorld& world, const hal::ArmDynamics& dynamics);

  /// Errors: BadConfig when it is not the world's.
  [[nodiscard]] hal::Result<> set_cycle(hal::Duration cycle) override;
  void command(const KrcSetPoint& set_point) override;
  void set_brakes(bool closed) override;
  void set_push(const Vector6& wrench) override { push_ = wrench; }
  void advance(hal::Duration by) override;
  [[nodiscard]] KrcPlantState state() const override;

 private:
  void tell_world();
  void tick_cartesian();
  [[nodiscard]] hal::JointVector push_nm() const;

  SimWorld& world_;
  hal::ArmDynamics dynamics_;
  KrcSetPoint set_point_;
  bool brakes_ = false, fresh_ = false;
  hal::JointVector brake_rad_, brake_nm_;
  hal::JointVector q_before_rad_, dq_rad_s_ = hal::JointVector::Zero();
  Vector6 push_ = Vector6::Zero();
};

}  // namespace colift::sim_hal
