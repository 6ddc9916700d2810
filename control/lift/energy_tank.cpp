#include "control/lift/energy_tank.hpp"

#include <algorithm>

namespace colift::control {

void EnergyTank::fill(double energy_j) {
  open_ = true;
  known_ = false;
  level_j_ = min_level_j_ = full_j_ = energy_j;
}

void EnergyTank::update(const hal::JointVector& q_rad, const hal::JointVector& torque_nm, double stored_j) {
  if (!open_ || !q_rad.allFinite() || !torque_nm.allFinite()) return;
  if (known_) {
    const double given_j = 0.5 * (torque_nm + torque_nm_).dot(q_rad - q_rad_);
    level_j_ = std::min(full_j_, level_j_ - given_j - (stored_j - stored_j_));
    min_level_j_ = std::min(min_level_j_, level_j_);
  }
  known_ = true;
  stored_j_ = stored_j;
  torque_nm_ = torque_nm;
  q_rad_ = q_rad;
}

double EnergyTank::speed_scale(double band_j) const {
  if (!open_) return 1.0;
  return band_j > 0.0 ? std::clamp(level_j_ / band_j, 0.0, 1.0) : (level_j_ > 0.0 ? 1.0 : 0.0);
}

}  // namespace colift::control
