#pragma once

#include <Eigen/Core>
#include <vector>

namespace colift::perception {

/// Half the size of a window around a pixel, and the distance of its samples (pixels).
struct SampledWindow {
  int u, v;  ///< Multiples of half the steps, so that the samples lie evenly about the middle.
  int step_u, step_v;

  [[nodiscard]] int samples() const { return (2 * u / step_u + 1) * (2 * v / step_v + 1); }
};

/// Sums over the object's samples in a window; offsets u, v from its middle (pixels), w: inverse depth less
/// that of the middle (1/m).
struct WindowSums {
  double n = 0, u = 0, v = 0, uu = 0, uv = 0, vv = 0;
  double w = 0, wu = 0, wv = 0, ww = 0;
};

/// The object in the image, as inverse depth.
struct InverseDepth {
  std::vector<float> values;  ///< Row-major; 0 where the object is not.
  int width = 0, height = 0;
};

/// Sums around a pixel of the image; what of the window lies beyond the image has no samples.
[[nodiscard]] WindowSums window_sums(const InverseDepth& object, int u, int v, const SampledWindow& window);

/// Normal equations of w = t . x over the object's samples in a window, with the terms t = (1, u, v, u^2, u
/// v, v^2).
struct QuadraticSums {
  Eigen::Matrix<double, 6, 6> normal;  ///< Sum of t t'.
  Eigen::Matrix<double, 6, 1> right;   ///< Sum of w t.
  double squares = 0, n = 0;           ///< Sum of w^2, number of samples.
};
[[nodiscard]] QuadraticSums quadratic_sums(const InverseDepth& object, int u, int v,
                                           const SampledWindow& window);

}  // namespace colift::perception
