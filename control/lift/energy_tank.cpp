#include "control/lift/energy_tank.hpp"

#include <algorithm>

namespace colift::control {

void EnergyTank::fill(double energy_j) {
  open_ = true;
  known_ = false;
  level_j_ = min_level_j_ = full_j_ = energy_j;
}

void EnergyTank::update(const hal::Pose& X_WH, const hal::Wrench& felt_W) {
  const bool usable = X_WH.matrix().allFinite() && felt_W.force.allFinite() && felt_W.torque.allFinite();
  if (!open_ || !usable) return;
  if (known_) {
    const hal::Vec3 moved = X_WH.translation() - X_WH_.translation();
    // a cycle turns the palm by so little that the rotation is its own skew part
    const Eigen::Matrix3d R = X_WH.linear() * X_WH_.linear().transpose();
    const hal::Vec3 turned = 0.5 * hal::Vec3(R(2, 1) - R(1, 2), R(0, 2) - R(2, 0), R(1, 0) - R(0, 1));
    const double given_j =
        -0.5 * ((felt_W.force + felt_W_.force).dot(moved) + (felt_W.torque + felt_W_.torque).dot(turned));
    level_j_ = std::min(full_j_, level_j_ - given_j);
    min_level_j_ = std::min(min_level_j_, level_j_);
  }
  known_ = true;
  X_WH_ = X_WH;
  felt_W_ = felt_W;
}

double EnergyTank::speed_scale(double band_j) const {
  if (!open_) return 1.0;
  return band_j > 0.0 ? std::clamp(level_j_ / band_j, 0.0, 1.0) : (level_j_ > 0.0 ? 1.0 : 0.0);
}

}  // namespace colift::control
