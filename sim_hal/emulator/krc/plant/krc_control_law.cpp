#include "sim_hal/emulator/krc/plant/krc_control_law.hpp"

#include "hal/types/symmetric.hpp"

namespace colift::sim_hal {
namespace {

constexpr double kPostureStiffness_nm_rad = 30.0, kPostureDamping = 0.7;
// keeps inverses finite where the arm is straight; far below what matters elsewhere
constexpr double kSingular = 1e-6;

}  // namespace

Vector6 frame_difference(const hal::Pose& from, const hal::Pose& to) {
  const Eigen::AngleAxisd turn(Eigen::Matrix3d(to.linear() * from.linear().transpose()));
  Vector6 d;
  d << to.translation() - from.translation(), turn.angle() * turn.axis();
  return d;
}

JointLaw joint_impedance(const KrcSetPoint& s, const hal::JointVector& q_rad, const hal::JointMatrix& M) {
  JointLaw law;
  law.stiffness.diagonal() = s.stiffness_nm_rad;
  law.damping.diagonal() =
      2.0 * s.damping_ratio.array() * (s.stiffness_nm_rad.array().max(0.0) * M.diagonal().array()).sqrt();
  law.feed_nm = s.stiffness_nm_rad.cwiseProduct(s.q_rad - q_rad) + s.tau_nm;
  return law;
}

JointLaw cartesian_impedance(const KrcSetPoint& s, const hal::JointVector& q_rad, const hal::Pose& X_WT,
                             const hal::ArmJacobian& J, const hal::JointMatrix& M) {
  using Matrix6 = Eigen::Matrix<double, 6, 6>;
  const Matrix6 mobility = J * hal::solve_small_symmetric(M, J.transpose()) + kSingular * Matrix6::Identity();
  const Vector6 mass = hal::solve_small_symmetric(mobility, Matrix6::Identity()).diagonal();
  const Vector6 damping =
      2.0 * s.cart_damping_ratio.array() * (s.cart_stiffness.array().max(0.0) * mass.array()).sqrt();

  const Matrix6 gram = J * J.transpose() + kSingular * Matrix6::Identity();
  const hal::JointMatrix null =
      hal::JointMatrix::Identity() - J.transpose() * hal::solve_small_symmetric(gram, J);
  const double posture_damping =
      2.0 * kPostureDamping * std::sqrt(kPostureStiffness_nm_rad * M.diagonal().mean());

  JointLaw law;
  law.stiffness = J.transpose() * s.cart_stiffness.asDiagonal() * J + kPostureStiffness_nm_rad * null;
  law.damping = J.transpose() * damping.asDiagonal() * J + posture_damping * null;
  law.feed_nm = J.transpose() * (s.cart_stiffness.cwiseProduct(frame_difference(X_WT, s.X_WT)) + s.wrench) +
                kPostureStiffness_nm_rad * null * (s.q_rad - q_rad);
  return law;
}

}  // namespace colift::sim_hal
