#pragma once

#include <Eigen/Core>

namespace colift::hal {

inline constexpr int kArmJoints = 7;

/// One value per joint of the arm, A1 first (rad, rad/s or N m as the name of the variable says).
using JointVector = Eigen::Matrix<double, kArmJoints, 1>;

}  // namespace colift::hal
