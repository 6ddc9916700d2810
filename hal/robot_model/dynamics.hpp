#pragma once

#include <array>

#include "hal/robot_model/robot_model.hpp"
#include "hal/types/units.hpp"

namespace colift::hal {

using JointMatrix = Eigen::Matrix<double, kArmJoints, kArmJoints>;

/// Rigid-body dynamics of the arm from its URDF: M(q) ddq + c(q, dq) + g(q) = tau, base fixed, z up.
/// Recursive Newton-Euler and composite rigid bodies (Featherstone, Rigid Body Dynamics Algorithms, ch. 5 and
/// 6) on fixed arrays. After construction real-time safe and free of state: any thread.
class ArmDynamics {
 public:
  enum class Load {
    Bare,  ///< The arm alone, up to its flange.
    Hand,  ///< With the hand as a rigid part of A7, in the posture that was given.
  };
  ArmDynamics(const RobotModel& model, Load load, const HandPosture& hand = {});

  /// Torque that holds the arm still: the derivative of its potential energy (N m).
  [[nodiscard]] JointVector gravity_nm(const JointVector& q_rad) const;
  /// Torque for a motion, gravity included (N m).
  [[nodiscard]] JointVector torque_nm(const JointVector& q_rad, const JointVector& dq_rad_s,
                                      const JointVector& ddq_rad_s2) const;
  /// Symmetric, positive definite (kg m^2).
  [[nodiscard]] JointMatrix mass_matrix(const JointVector& q_rad) const;

  /// What a controller wants in every cycle, in one walk along the arm.
  struct Tick {
    Pose X_WF = Pose::Identity();                  ///< flange()
    ArmJacobian jacobian = ArmJacobian::Zero();    ///< jacobian()
    JointVector gravity_nm = JointVector::Zero();  ///< gravity_nm()
  };
  [[nodiscard]] Tick tick(const JointVector& q_rad, const Vec3& p_F = Vec3::Zero()) const;

  /// Pose of the flange F in W.
  [[nodiscard]] Pose flange(const JointVector& q_rad) const;
  /// Geometric Jacobian of the point p_F, fixed to the flange: rows linear (m/rad), then angular, in W.
  [[nodiscard]] ArmJacobian jacobian(const JointVector& q_rad, const Vec3& p_F = Vec3::Zero()) const;

 private:
  /// A joint and all that it carries up to the next one, in the frame of its link.
  struct Body {
    Pose X_PB0 = Pose::Identity();  ///< In the body before (first: in W) at joint position 0.
    Vec3 axis = Vec3::UnitZ();
    /// Turn in the body before at joint position q: fixed + sin q sine + cos q cosine (Rodrigues).
    Eigen::Matrix3d fixed = Eigen::Matrix3d::Zero(), sine = fixed, cosine = fixed;
    double mass_kg = 0.0;
    Vec3 moment = Vec3::Zero();                         ///< Mass times centre of mass (kg m).
    Eigen::Matrix3d inertia = Eigen::Matrix3d::Zero();  ///< About the frame's origin (kg m^2).
  };
  using Bodies = std::array<Body, kArmJoints>;
  /// Turn and origin of each body in the one before.
  struct Place {
    Eigen::Matrix3d R;
    Vec3 p;
  };
  using Places = std::array<Place, kArmJoints>;

  [[nodiscard]] Places places(const JointVector& q_rad) const;

  Bodies bodies_;
  Pose X_A7F_ = Pose::Identity();
};

}  // namespace colift::hal
