#include "control/arm/contact_wrench.hpp"

#include <algorithm>

#include "hal/types/symmetric.hpp"
#include "hal/types/units.hpp"

namespace colift::control {
namespace {

// Prior of a contact; chosen, as the force at which an approach stops.
constexpr double kContact_n = 30.0, kContact_nm = 3.0;
// Added where no error is known, so that singular postures have a solution.
constexpr double kLeastError_nm = 1e-3;

}  // namespace

hal::Wrench contact_wrench(const hal::RobotModel& model, const hal::JointVector& q_rad,
                           const hal::JointVector& tare_rise_m, const hal::JointVector& tau_nm,
                           const TorqueErrors& errors) {
  const hal::ArmJacobian J = hal::jacobian(model, q_rad, hal::Vec3::Zero());
  const double joint_nm = std::max(errors.joint_nm, kLeastError_nm);
  // torques of a kilogram more in the tool than when they were tared; the covariance of all errors is that of
  // the sensors and one direction more, and so is its inverse (Sherman and Morrison 1950)
  const hal::JointVector weight = -hal::kGravity_m_s2 * (J.row(2).transpose() - tare_rise_m);
  const double mass2 = errors.tool_kg * errors.tool_kg;
  const double part = mass2 / (joint_nm * joint_nm + mass2 * weight.squaredNorm());
  using Vector6 = Eigen::Matrix<double, 6, 1>;
  const Vector6 Jw = J * weight;
  Eigen::Matrix<double, 6, 6> A = J * J.transpose() - part * Jw * Jw.transpose();
  A.diagonal().head<3>().array() += joint_nm * joint_nm / (kContact_n * kContact_n);
  A.diagonal().tail<3>().array() += joint_nm * joint_nm / (kContact_nm * kContact_nm);
  const Vector6 b = J * tau_nm - part * weight.dot(tau_nm) * Jw;
  const Vector6 F = hal::solve_symmetric<double, 6>(A, b);
  return {F.head<3>(), F.tail<3>()};
}

hal::JointVector palm_rise(const hal::RobotModel& model, const hal::JointVector& q_rad) {
  return hal::jacobian(model, q_rad, hal::Vec3::Zero()).row(2).transpose();
}

}  // namespace colift::control
