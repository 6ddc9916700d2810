#pragma once

#include <string>

#include "hal/types/geometry.hpp"

namespace colift::control {

/// Where a place is for a person who stands at `from` and faces `middle` (W, m): "0.20 m further left and
/// 0.10 m further on". Empty for less than half a hand's width.
[[nodiscard]] std::string place_words(const hal::Vec3& from, const hal::Vec3& to,
                                      const Eigen::Vector2d& middle);

}  // namespace colift::control
