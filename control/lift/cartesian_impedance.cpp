#include "control/lift/cartesian_impedance.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

namespace colift::control {
namespace {

constexpr double kSingular = 1e-3;  // m^3; minors of a posture in which the null motion is not one

using Matrix7 = Eigen::Matrix<double, hal::kArmJoints, hal::kArmJoints>;

/// The motion that moves no palm, of length 1; shorter near singular postures, where it is not one motion.
/// Its components are the minors of the Jacobian (Cramer).
hal::JointVector null_motion(const hal::ArmJacobian& J) {
  hal::JointVector n;
  for (int i = 0; i < hal::kArmJoints; ++i) {
    Eigen::Matrix<double, 6, 6> rest;
    for (int c = 0, to = 0; c < hal::kArmJoints; ++c)
      if (c != i) rest.col(to++) = J.col(c);
    n[i] = (i % 2 == 0 ? 1.0 : -1.0) * rest.determinant();
  }
  return n / std::sqrt(n.squaredNorm() + kSingular * kSingular);
}

}  // namespace

CartesianImpedance::CartesianImpedance(const hal::RobotModel& model, const CartesianConfig& config,
                                       double joint_nm_rad, const hal::ArmAbilities& arm, double slope_nm_s)
    : model_(&model), config_(config), joint_nm_rad_(joint_nm_rad), arm_(arm), slope_nm_s_(slope_nm_s) {}

hal::JointVector CartesianImpedance::stiffness_nm_rad(double joints_nm_rad) const {
  return joints_nm_rad * (hal::JointVector::Ones() + weight_ * (diagonal_ - hal::JointVector::Ones()));
}

void CartesianImpedance::reset() {
  weight_ = 0.0;
  superposed_nm_.setZero();
}

hal::ImpedanceCommand CartesianImpedance::apply(const hal::JointVector& q_rad,
                                                const hal::ImpedanceCommand& joints, double dt_s) {
  const double step = dt_s / config_.blend_s;
  weight_ = std::clamp(weight_ + (engaged_ ? step : -step), 0.0, 1.0);
  if (!q_rad.allFinite()) {
    reset();
    return joints;
  }
  const hal::JointVector off = joints.q_rad - q_rad;
  spring_nm_ = joints.stiffness_nm_rad.cwiseProduct(off);
  const auto superposed = [&](const hal::JointVector& wanted_nm) {
    const hal::JointVector most = hal::JointVector::Constant(slope_nm_s_ * dt_s);
    superposed_nm_ +=
        (wanted_nm.cwiseMax(-arm_.max_superposed_nm).cwiseMin(arm_.max_superposed_nm) - superposed_nm_)
            .cwiseMax(-most)
            .cwiseMin(most);
    return superposed_nm_;
  };
  if (weight_ == 0.0) {
    superposed_nm_ = joints.tau_superposed_nm;
    return joints;
  }

  const hal::Pose X_WH = hal::hand_pose(*model_, q_rad), X_WHd = hal::hand_pose(*model_, joints.q_rad);
  const hal::ArmJacobian J = hal::jacobian(*model_, q_rad, hal::Vec3::Zero());
  const Eigen::AngleAxisd turn(Eigen::Matrix3d(X_WHd.linear() * X_WH.linear().transpose()));
  Eigen::Matrix<double, 6, 1> away, stiffness;
  away << X_WHd.translation() - X_WH.translation(), turn.angle() * turn.axis();
  stiffness << config_.side_n_m, config_.side_n_m, config_.up_n_m, config_.tilt_nm_rad, config_.tilt_nm_rad,
      config_.turn_nm_rad;
  const double soft = joint_nm_rad_ > 0.0 ? joints.stiffness_nm_rad[0] / joint_nm_rad_ : 1.0;
  stiffness *= soft;
  const hal::JointVector n = null_motion(J);
  const double null_nm_rad = soft * config_.null_nm_rad;
  const hal::JointVector palm_nm =
      J.transpose() * stiffness.cwiseProduct(away) + null_nm_rad * n.dot(off) * n;
  const hal::JointVector diagonal =
      ((J.transpose() * stiffness.asDiagonal() * J).diagonal() + null_nm_rad * n.cwiseAbs2())
          .cwiseMin(arm_.max_stiffness_nm_rad);

  diagonal_ = diagonal.cwiseQuotient(joints.stiffness_nm_rad.cwiseMax(1.0));
  spring_nm_ += weight_ * (palm_nm - spring_nm_);
  hal::ImpedanceCommand command = joints;
  command.stiffness_nm_rad += weight_ * (diagonal - joints.stiffness_nm_rad);
  command.tau_superposed_nm =
      superposed(joints.tau_superposed_nm + spring_nm_ - command.stiffness_nm_rad.cwiseProduct(off));
  return command;
}

}  // namespace colift::control
