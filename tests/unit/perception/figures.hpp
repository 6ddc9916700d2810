#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include "hal/types/geometry.hpp"

namespace colift::perception {

/// Angle between two directions of any length (deg).
inline double angle_deg(const hal::Vec3& a, const hal::Vec3& b) {
  return std::atan2(a.cross(b).norm(), a.dot(b)) * 180.0 / M_PI;
}

/// The value below which a part (0 to 1) of all lies; NaN of none.
inline double quantile(std::vector<double> values, double part) {
  if (values.empty()) return std::nan("");
  std::sort(values.begin(), values.end());
  return values[static_cast<std::size_t>(part * static_cast<double>(values.size() - 1) + 0.5)];
}

}  // namespace colift::perception
