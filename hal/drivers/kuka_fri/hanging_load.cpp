#include "hal/drivers/kuka_fri/hanging_load.hpp"

#include <cmath>

#include "hal/drivers/kuka_fri/wire/lwr_limits.hpp"

namespace colift::hal {
namespace {

// Less is friction and noise; and how much alike wrench and sag are (cosine).
constexpr double kMinLoad_n = 5.0, kMinSag_m = 0.002, kMinAlong = 0.8;

// Rows of the wire's Jacobian are X Y Z Rz Ry Rx.
SixVector displacement(const FriMeasurement& m, const JointVector& off_rad) {
  SixVector d = SixVector::Zero();
  for (int row = 0; row < 6; ++row)
    for (int joint = 0; joint < kArmJoints; ++joint)
      d[row < 3 ? row : 8 - row] +=
          static_cast<double>(m.jacobian[static_cast<std::size_t>(row * kArmJoints + joint)]) *
          off_rad[joint];
  return d;
}

}  // namespace

SixVector bounded_wrench(const SixVector& wrench) {
  SixVector most;
  most << Vec3::Constant(kLwrPayloadForce_n), Vec3::Constant(kLwrPayloadTorque_nm);
  return wrench.cwiseMax(-most).cwiseMin(most);
}

SixVector wrench_against_load(const FriMeasurement& m, const ArmState& now) {
  const JointVector off_rad = now.q_rad - now.q_commanded_rad;
  const SixVector load = from_wire_order(m.wrench_external), sag = displacement(m, off_rad);
  if (!load.allFinite() || !sag.allFinite() || !JointSetPoint::explained(off_rad, now.tau_external_nm))
    return SixVector::Zero();
  const double force_n = load.head<3>().norm(), sag_m = sag.head<3>().norm();
  if (force_n < kMinLoad_n || sag_m < kMinSag_m) return SixVector::Zero();
  const double cosine = load.head<3>().dot(sag.head<3>()) / (force_n * sag_m);
  if (std::abs(cosine) < kMinAlong) return SixVector::Zero();
  return bounded_wrench(cosine > 0.0 ? SixVector(-load) : load);
}

}  // namespace colift::hal
