#pragma once

#include "sim_hal/emulator/krc/krc_rules.hpp"

namespace colift::sim_hal {

/// The program's $STIFFNESS: what holds where the client's flags are clear, and in monitor mode.
struct KrlStiffness {
  double axis_nm_rad = 1000.0, axis_damping = 0.7;
  double cart_n_m = 200.0, cart_nm_rad = 20.0, cart_damping = 0.7;
};

/// What the KRC commands: the program's part, FRI's part on top of it, and how both come to rest.
class KrcMotion {
 public:
  KrcMotion(const hal::ArmDynamics& dynamics, const hal::Pose& X_FT, const KrcLimits& limits,
            hal::Duration cycle);

  /// A motion of the program to where the arm is: the program commands this pose now, FRI adds nothing.
  void start_at(const hal::JointVector& q_rad);
  /// The same to where FRI has brought it.
  void fold() { start_at(q_rad_); }
  void set_strategy(FriControl control, const KrlStiffness& stiffness);
  void set_cycle(hal::Duration cycle) { cycle_s_ = hal::seconds(cycle); }
  void set_measured(const KrcPlantState& measured);

  [[nodiscard]] KrcJudgedAt judged_at() const;

  void enter(std::uint32_t flags, double safety_limits);
  /// A command that was judged good.
  void follow(const KrcCommand& command);
  /// A cycle without one: positions go on as they went, all else holds.
  void extrapolate();
  /// A cycle without news.
  void repeat();
  /// Out of command mode: brings the commanded motion to rest, superposed torque to zero, gains to the
  /// program's.
  void leave();
  /// One cycle of it. True once it is at rest.
  bool come_to_rest();

  [[nodiscard]] const KrcSetPoint& set_point() const { return set_point_; }
  [[nodiscard]] FriControl control() const { return control_; }
  [[nodiscard]] const hal::JointVector& q_rad() const { return q_rad_; }  ///< In all.
  [[nodiscard]] const hal::JointVector& q_krl_rad() const { return q_krl_rad_; }
  [[nodiscard]] const hal::Pose& X_WT() const { return X_WT_; }  ///< In all.
  [[nodiscard]] const hal::Pose& X_WT_krl() const { return X_WT_krl_; }
  [[nodiscard]] const hal::Pose& X_WT_measured() const { return X_WT_measured_; }
  [[nodiscard]] hal::Pose tool(const hal::JointVector& q_rad) const {
    return dynamics_.flange(q_rad) * X_FT_;
  }

 private:
  void use_program_gains();
  [[nodiscard]] bool cartesian() const { return control_ == FriControl::CartesianImpedance; }

  const hal::ArmDynamics& dynamics_;
  hal::Pose X_FT_;
  KrcLimits limits_;
  double cycle_s_;

  FriControl control_ = FriControl::Position;
  KrlStiffness stiffness_;
  KrcSetPoint set_point_;
  hal::JointVector q_rad_, q_krl_rad_;
  hal::Pose X_WT_ = hal::Pose::Identity(), X_WT_krl_ = hal::Pose::Identity();
  KrcPlantState measured_;
  hal::Pose X_WT_measured_ = hal::Pose::Identity();

  // of the commands
  std::uint32_t flags_ = 0;
  double safety_limits_ = 1.0;
  hal::JointVector q_received_rad_, q_step_rad_ = hal::JointVector::Zero();  // step: per cycle
  hal::Pose X_received_ = hal::Pose::Identity();
  Vector6 X_step_ = Vector6::Zero();
  int cycles_since_ = 0;
  hal::JointVector tau_fade_nm_ = hal::JointVector::Zero();
};

}  // namespace colift::sim_hal
