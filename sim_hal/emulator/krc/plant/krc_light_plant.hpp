#pragma once

#include "sim_hal/emulator/krc/plant/krc_limits.hpp"

namespace colift::sim_hal {

struct LightPlantConfig {
  hal::JointVector start_rad = hal::JointVector::Zero();
  bool friction = false;  ///< Coulomb and viscous, the values of ISIR's public model.
};

/// The arm as a rigid body under the KRC's law, no physics engine, nothing to touch: implicit Euler at 1 ms,
/// stable for any allowed gain. In position control it follows with a short lag, as fast as its drives are.
class LightPlant final : public KrcPlant {
 public:
  LightPlant(const hal::ArmDynamics& dynamics, const LightPlantConfig& config);

  [[nodiscard]] hal::Result<> set_cycle(hal::Duration cycle) override;
  void command(const KrcSetPoint& set_point) override;
  void set_brakes(bool closed) override;
  void set_push(const Vector6& wrench) override { push_ = wrench; }
  void advance(hal::Duration by) override;
  [[nodiscard]] KrcPlantState state() const override { return state_; }

 private:
  void tick();

  hal::ArmDynamics dynamics_;
  LightPlantConfig config_;
  KrcLimits limits_;
  KrcSetPoint set_point_;
  hal::JointVector q_now_rad_;  // on the way to the set point, in steps of 1 ms
  int ticks_ = 1, ticks_left_ = 0;
  bool brakes_ = true;
  Vector6 push_ = Vector6::Zero();
  KrcPlantState state_;
};

}  // namespace colift::sim_hal
