#pragma once

#include <cstddef>
#include <functional>
#include <span>
#include <vector>

#include "hal/types/joints.hpp"

namespace colift::planner {

/// Way points in joint space (rad), joined by straight lines.
using JointPath = std::vector<hal::JointVector>;

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

/// Largest difference in any joint (rad).
[[nodiscard]] inline double joint_distance(const hal::JointVector& a, const hal::JointVector& b) {
  return (a - b).cwiseAbs().maxCoeff();
}

/// Euclidean length in joint space (rad).
[[nodiscard]] inline double length_of(std::span<const hal::JointVector> path) {
  double sum = 0.0;
  for (std::size_t i = 1; i < path.size(); ++i) sum += (path[i] - path[i - 1]).norm();
  return sum;
}

}  // namespace colift::planner
