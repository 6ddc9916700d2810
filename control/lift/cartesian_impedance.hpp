#pragma once

#include "control/config/cartesian_config.hpp"
#include "hal/arm.hpp"
#include "hal/robot_model/robot_model.hpp"

namespace colift::control {

/// Impedance of the palm for an arm that offers impedance of its joints: tau = J^T K_x e + k_n n n^T (q_d -
/// q), e the palm's way to the set point (m, rad; W, about the palm), n the arm's null motion. K_x is stiff
/// along gravity and in tilt, soft sideways and about the vertical. Both terms are springs of one potential
/// energy.
///
/// The diagonal of the same stiffness in joint space is left to the controller, which serves it and its
/// damping a thousand times a second; only what couples the joints goes over the link as superposed torque.
/// So a slow or lost link takes the coupling, not the springs. (Hogan 1985; Albu-Schaeffer et al., Int. J.
/// Robotics Research 26, 2007, for the combination on the LWR.) One thread; allocation-free.
class CartesianImpedance {
 public:
  /// The superposed torque changes by at most `slope_nm_s`.
  CartesianImpedance(const hal::RobotModel& model, const CartesianConfig& config, double joint_nm_rad,
                     const hal::ArmAbilities& arm, double slope_nm_s);

  /// From now on one impedance turns into the other, in CartesianConfig::blend_s.
  void engage(bool on) { engaged_ = on; }
  /// The arm starts from its measured pose, with nothing superposed: the joints' impedance, for now.
  void reset();
  /// 0: impedance of the joints, 1: of the palm.
  [[nodiscard]] double weight() const { return weight_; }

  /// The same command with the palm's springs, by weight(), instead of the joints'. A stiffness below the
  /// `joint_nm_rad` of the constructor (an arm that yields) softens the palm alike.
  [[nodiscard]] hal::ImpedanceCommand apply(const hal::JointVector& q_rad,
                                            const hal::ImpedanceCommand& joints, double dt_s);
  /// Stiffness of each joint in the last command, were it the joints' springs that have this one.
  [[nodiscard]] hal::JointVector stiffness_nm_rad(double joints_nm_rad) const;
  /// What the springs of the last command gave at the measured position, without what was superposed (N m).
  [[nodiscard]] const hal::JointVector& spring_nm() const { return spring_nm_; }

 private:
  const hal::RobotModel* model_;
  CartesianConfig config_;
  double joint_nm_rad_;
  hal::ArmAbilities arm_;
  double slope_nm_s_;
  hal::JointVector superposed_nm_ = hal::JointVector::Zero();  ///< Of the last command.
  bool engaged_ = false;
  double weight_ = 0.0;
  hal::JointVector diagonal_ =
      hal::JointVector::Ones();  ///< Of the palm's stiffness over that of the joints.
  hal::JointVector spring_nm_ = hal::JointVector::Zero();
};

}  // namespace colift::control
