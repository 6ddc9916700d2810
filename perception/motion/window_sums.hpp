#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

namespace colift::perception {

/// Half the size of a window around a pixel (pixels).
struct Window {
  int u, v;

  [[nodiscard]] int pixels() const { return (2 * u + 1) * (2 * v + 1); }
};

/// Sums over the object's pixels in a window; offsets u, v from its middle (pixels), w: inverse depth less
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

/// Integral images of an object (Crow 1984): the sums of any window in the same few steps.
class WindowIntegrals {
 public:
  explicit WindowIntegrals(const InverseDepth& object);

  /// Around a pixel of the image; what of the window lies beyond the image has no pixels. Same `object`.
  [[nodiscard]] WindowSums sums(const InverseDepth& object, int u, int v, const Window& window) const;

 private:
  using Sums = std::array<double, 10>;  // in the order of WindowSums

  [[nodiscard]] const Sums& above_left(int u, int v) const;

  int u0_ = 0, v0_ = 0, width_ = 0, height_ = 0;  // the part of the image with the object in it
  double mean_ = 0.0;                             // inverse depth, near which little is lost to rounding
  std::vector<Sums> sums_;                        // of all pixels above and to the left
};

/// Normal equations of w = t . x over the object's pixels in a window, with the terms t = (1, u, v, u^2, u
/// v, v^2).
struct QuadraticSums {
  Eigen::Matrix<double, 6, 6> normal;  ///< Sum of t t'.
  Eigen::Matrix<double, 6, 1> right;   ///< Sum of w t.
  double squares = 0, n = 0;           ///< Sum of w^2, number of pixels.
};
[[nodiscard]] QuadraticSums quadratic_sums(const InverseDepth& object, int u, int v, const Window& window);

}  // namespace colift::perception
