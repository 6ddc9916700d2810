#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "hal/types/joints.hpp"

namespace colift::planner {

/// Way points in joint space (rad), joined by straight lines.
using JointPath = std::vector<hal::JointVector>;

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
