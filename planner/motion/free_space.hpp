#pragma once

#include <functional>

#include "hal/types/joints.hpp"

namespace colift::planner {

/// What searches need to know of the collision world: joint positions and straight motions that are free.
struct FreeSpace {
  std::function<bool(const hal::JointVector&)> state;
  std::function<bool(const hal::JointVector&, const hal::JointVector&)> edge;
};

/// Box of joint positions in which a search stays (rad).
struct JointBox {
  hal::JointVector lower_rad = hal::JointVector::Zero(), upper_rad = hal::JointVector::Zero();

  /// The box with a point drawn in, so that a search may start where it stands.
  [[nodiscard]] JointBox with(const hal::JointVector& q_rad) const {
    return {lower_rad.cwiseMin(q_rad), upper_rad.cwiseMax(q_rad)};
  }
  [[nodiscard]] bool contains(const hal::JointVector& q_rad) const {
    return (q_rad.array() >= lower_rad.array()).all() && (q_rad.array() <= upper_rad.array()).all();
  }
};

}  // namespace colift::planner
