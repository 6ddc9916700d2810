#include "sim_hal/judge/commanded_energy.hpp"

#include <algorithm>

namespace colift::sim_hal {

void CommandedEnergy::tick(const TickReport& r, bool rests) {
  const hal::JointVector& q = r.truth.q_rad;
  if (known_ && !rests) {
    // d/dt of K (q_d - q)^2 / 2 - tau_s q at a standing q, by the trapezoidal rule
    const hal::JointVector stretch = r.set_point_rad - q, before = set_point_rad_ - q_rad_;
    const hal::JointVector spring_nm =
        stiffness_nm_rad_.cwiseProduct(0.5 * (stretch + before)) - rest_spring_nm_;
    sum_j_ += spring_nm.dot(r.set_point_rad - set_point_rad_);
    sum_j_ += 0.5 * (r.impedance.stiffness_nm_rad - stiffness_nm_rad_).dot(stretch.cwiseAbs2());
    sum_j_ -= (r.impedance.tau_superposed_nm - superposed_nm_).dot(q - rest_rad_);
    lowest_j_ = std::min(lowest_j_, sum_j_);
  }
  q_rad_ = q;
  set_point_rad_ = r.set_point_rad;
  stiffness_nm_rad_ = r.impedance.stiffness_nm_rad;
  superposed_nm_ = r.impedance.tau_superposed_nm;
  if (known_ && !rests) return;
  known_ = true;
  sum_j_ = lowest_j_ = 0.0;
  rest_rad_ = q;
  rest_spring_nm_ = stiffness_nm_rad_.cwiseProduct(set_point_rad_ - q);
}

}  // namespace colift::sim_hal
