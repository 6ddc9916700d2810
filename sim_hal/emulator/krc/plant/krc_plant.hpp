#pragma once

#include "hal/robot_model/dynamics.hpp"
#include "hal/types/result.hpp"
#include "hal/types/time.hpp"
#include "sim_hal/emulator/krc/krc_wire.hpp"

namespace colift::sim_hal {

using Vector6 = Eigen::Matrix<double, 6, 1>;

/// What the KRC's motion kernel is told for one cycle. Six-dimensional values are here in the usual order x y
/// z, rx ry rz; the tool T's frame is in W.
struct KrcSetPoint {
  FriControl control = FriControl::JointImpedance;
  hal::JointVector q_rad = hal::JointVector::Zero();  ///< In Cartesian impedance the posture to lean to.
  hal::JointVector stiffness_nm_rad = hal::JointVector::Constant(1000.0);
  hal::JointVector damping_ratio = hal::JointVector::Constant(0.7);
  hal::JointVector tau_nm = hal::JointVector::Zero();  ///< Superposed.
  hal::Pose X_WT = hal::Pose::Identity();
  Vector6 cart_stiffness = Vector6::Zero();  ///< N/m, N m/rad.
  Vector6 cart_damping_ratio = Vector6::Zero();
  Vector6 wrench = Vector6::Zero();  ///< Superposed, about T, axes of W.
};

struct KrcPlantState {
  hal::JointVector q_rad = hal::JointVector::Zero(), dq_rad_s = hal::JointVector::Zero();
  hal::JointVector tau_nm = hal::JointVector::Zero();           ///< Of the joint torque sensors.
  hal::JointVector tau_external_nm = hal::JointVector::Zero();  ///< Of contacts on the arm.
};

/// The arm under the controller: its impedance law at 1 kHz, its brakes, its mass. One thread.
class KrcPlant {
 public:
  virtual ~KrcPlant() = default;
  /// Time between two commands, over which set points are interpolated. Errors: BadConfig.
  [[nodiscard]] virtual hal::Result<> set_cycle(hal::Duration cycle) = 0;
  virtual void command(const KrcSetPoint& set_point) = 0;
  /// Closed brakes hold the arm where it is, whatever is commanded.
  virtual void set_brakes(bool closed) = 0;
  /// A push on the tool from outside, about T, axes of W; stays until it is changed.
  virtual void set_push(const Vector6& wrench) = 0;
  /// Whole milliseconds.
  virtual void advance(hal::Duration by) = 0;
  [[nodiscard]] virtual KrcPlantState state() const = 0;
};

}  // namespace colift::sim_hal
