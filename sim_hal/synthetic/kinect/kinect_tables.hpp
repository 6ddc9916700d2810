#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numbers>

namespace colift::sim_hal {

/// Quantiles of the standard normal distribution at the middle of 4096 equal steps of probability; ends
/// at 3.7 sigma.
inline const std::array<float, 4096>& normal_quantiles() {
  static const auto table = [] {
    std::array<float, 4096> q{};
    double x = -3.7;
    for (std::size_t i = 0; i < q.size(); ++i) {
      const double p = (static_cast<double>(i) + 0.5) / static_cast<double>(q.size());
      // Newton from the quantile before; the density changes little from one to the next
      for (int step = 0; step < 8; ++step) {
        const double density = std::exp(-0.5 * x * x) / std::sqrt(2.0 * std::numbers::pi);
        x -= (0.5 * std::erfc(-x / std::numbers::sqrt2) - p) / density;
      }
      q[i] = static_cast<float>(x);
    }
    return q;
  }();
  return table;
}

inline constexpr int kMostSteps = 4;  ///< That a ray wanders.

/// How far the ray of a pixel wanders at an edge (px), over the same quantiles.
inline const std::array<std::int8_t, 4096>& wander_steps() {
  static const auto table = [] {
    constexpr double kJitter_px = 0.9;
    std::array<std::int8_t, 4096> steps{};
    for (std::size_t i = 0; i < steps.size(); ++i)
      steps[i] = static_cast<std::int8_t>(std::lround(kJitter_px * normal_quantiles()[i]));
    return steps;
  }();
  return table;
}

}  // namespace colift::sim_hal
