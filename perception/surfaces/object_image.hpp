#pragma once

#include <cmath>
#include <cstdint>
#include <vector>

#include "perception/noise_model.hpp"
#include "perception/organised_cloud.hpp"
#include "perception/surfaces/inverse_plane.hpp"

namespace colift::perception {

/// The part of the image that holds the object, as inverse depths. Pixel (i, j) is entry j * width + i; its
/// coordinates U, V for planes are i and j themselves. Around the object is a rim of at least one pixel, and
/// both sides are whole numbers of cells.
struct ObjectImage {
  static constexpr int kCell = 8;            ///< Side of a cell (pixels).
  static constexpr std::int16_t kFree = -1;  ///< Label of object pixels that no surface has.
  static constexpr std::int16_t kOutside = -2;
  static constexpr std::int16_t kCylinder = -3;

  ImageGeometry geometry;
  int u0, v0, width, height;
  std::vector<float> q;  ///< 1/z of the object's pixels; 0 elsewhere.
  std::vector<std::int16_t>
      label;  ///< Index of the surface that a pixel lies on, kFree, kOutside or kCylinder.
  std::vector<std::uint32_t> pixels;  ///< Entries of the object's pixels, ascending.
  NoiseModel noise;
  double tolerance_m = 0;  ///< Unevenness and lens distortion, added to the noise's tolerance.

  ObjectImage(const OrganisedCloud& cloud, const std::vector<std::uint32_t>& target_pixels,
              const NoiseModel& noise, double tolerance_m);

  [[nodiscard]] std::size_t at(int i, int j) const {
    return static_cast<std::size_t>(j) * static_cast<std::size_t>(width) + static_cast<std::size_t>(i);
  }
  [[nodiscard]] int column(std::uint32_t pixel) const { return static_cast<int>(pixel) % width; }
  [[nodiscard]] int row(std::uint32_t pixel) const { return static_cast<int>(pixel) / width; }

  /// Standard deviation of 1/z of a pixel on an even surface: noise and half of the unevenness.
  [[nodiscard]] double sigma(double inverse_depth) const {
    const double square = inverse_depth * inverse_depth;
    const double depth = noise.sigma2_per_m + noise.sigma0_m * square, uneven = 0.5 * tolerance_m * square;
    return std::sqrt(depth * depth + uneven * uneven);
  }
  /// Residual of 1/z up to which a pixel may lie on a surface, at a number of standard deviations. Unevenness
  /// lies along the surface's normal: `slant` is how far a point moves along that for a metre of depth.
  [[nodiscard]] double tolerance(double inverse_depth, double sigmas, double slant = 1.0) const {
    const double square = inverse_depth * inverse_depth;
    return sigmas * (noise.sigma2_per_m + noise.sigma0_m * square) + tolerance_m / slant * square;
  }
  /// Side of a pixel's footprint on a surface that faces the camera (m).
  [[nodiscard]] double pixel_m(double inverse_depth) const {
    return 1.0 / (geometry.focal() * inverse_depth);
  }
};

}  // namespace colift::perception
