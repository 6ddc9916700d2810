#include "control/lift/load_estimator.hpp"

#include <cmath>

#include "hal/types/symmetric.hpp"

namespace colift::control {

namespace {

using Matrix6 = Eigen::Matrix<double, 6, 6>;
using Vector6 = Eigen::Matrix<double, 6, 1>;

// Of the arm's kinematics, not of a job: below this manipulability (m^3) a posture counts as nearly singular.
// The damping is that of Nakamura and Hanafusa 1986; both figures were chosen, not measured.
constexpr double kMinManipulability = 0.01;
constexpr double kMostDamping = 0.05;

}  // namespace

hal::Wrench palm_wrench(const hal::RobotModel& model, const hal::JointVector& q_rad,
                        const hal::JointVector& tau_external_nm) {
  const hal::ArmJacobian J = hal::jacobian(model, q_rad, hal::Vec3::Zero());
  Matrix6 JJ = J * J.transpose();
  const double manipulability = std::sqrt(std::max(0.0, hal::symmetric_determinant(JJ)));
  if (manipulability < kMinManipulability) {
    const double near = 1.0 - manipulability / kMinManipulability;
    JJ.diagonal().array() += kMostDamping * kMostDamping * near * near;
  }
  const Vector6 F = hal::solve_symmetric<double, 6>(JJ, J * tau_external_nm);
  return {F.head<3>(), F.tail<3>()};
}

LoadEstimator::LoadEstimator(const hal::RobotModel& model, const LoadConfig& config)
    : model_(&model), config_(config) {}

void LoadEstimator::start_tare() {
  taring_ = true;
  tare_count_ = 0;
  tare_sum_.setZero();
}

void LoadEstimator::end_tare() {
  if (taring_ && tare_count_ > 0) {
    tare_ = tare_sum_ / tare_count_;
    wrench_ = hal::Wrench{};  // what was felt until now was nothing
  }
  taring_ = false;
}

void LoadEstimator::update(hal::Timestamp at, const hal::JointVector& q_rad,
                           const hal::JointVector& tau_external_nm) {
  if (!q_rad.allFinite() || !tau_external_nm.allFinite() || (last_ && at <= *last_)) return;
  if (taring_) {
    tare_sum_ += tau_external_nm;
    ++tare_count_;
  }
  const hal::Wrench now = palm_wrench(*model_, q_rad, tau_external_nm - tare_);
  if (wrench_ && last_ && config_.filter_s > 0.0) {
    const double part = 1.0 - std::exp(-hal::seconds(at - *last_) / config_.filter_s);
    wrench_->force += part * (now.force - wrench_->force);
    wrench_->torque += part * (now.torque - wrench_->torque);
  } else {
    wrench_ = now;
  }
  last_ = at;
}

std::optional<hal::Wrench> LoadEstimator::wrench_W() const {
  return wrench_;
}

double LoadEstimator::load_n() const {
  return wrench_ ? -wrench_->force.z() : 0.0;
}

}  // namespace colift::control
