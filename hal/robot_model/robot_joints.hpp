#pragma once

#include <cstddef>

#include "hal/hand.hpp"
#include "hal/types/joints.hpp"

namespace colift::hal {

// Order of the joints that move, as RobotModel::turned_by_ counts them: A1 to A7, the inner joints of F1 to
// F3, their outer joints, the spread joints of F1 and F2.
inline constexpr std::size_t kFirstInner = kArmJoints;
inline constexpr std::size_t kFirstOuter = kFirstInner + kFingers;
inline constexpr std::size_t kFirstSpread = kFirstOuter + kFingers;
inline constexpr std::size_t kMovingJoints = kFirstSpread + 2;

}  // namespace colift::hal
