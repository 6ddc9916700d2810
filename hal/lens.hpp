#pragma once

#include <array>
#include <string>
#include <vector>

#include "hal/depth_camera.hpp"

namespace colift::hal {

/// Lens distortion after Brown and Conrady with the rational radial term, as OpenCV's calibrateCamera() gives
/// it: a ray (x, y, 1) is imaged at the pinhole image of (x', y'), where with r^2 = x^2 + y^2 x' = x (1 + k1
/// r^2 + k2 r^4 + k3 r^6) / (1 + k4 r^2 + k5 r^4 + k6 r^6) + 2 p1 x y + p2 (r^2 + 2 x^2), y' alike.
struct LensDistortion {
  double k1 = 0.0, k2 = 0.0, p1 = 0.0, p2 = 0.0, k3 = 0.0, k4 = 0.0, k5 = 0.0, k6 = 0.0;

  [[nodiscard]] bool none() const;
  /// Where the ray through (x, y) at unit depth is imaged.
  [[nodiscard]] std::array<double, 2> distort(double x, double y) const;
  /// The ray that is imaged there: the inverse, by fixed-point iteration, for a lens that is unique_within().
  [[nodiscard]] std::array<double, 2> undistort(double x, double y) const;
  /// Whether no two rays inside the image share a pixel along a line from its centre.
  [[nodiscard]] bool unique_within(const CameraIntrinsics& camera) const;
};

/// What no depth camera is like: a size, focal lengths, a principal point, a distortion that maps two rays to
/// one pixel. One sentence with the figure; empty: it may be one.
[[nodiscard]] std::string impossible(const CameraIntrinsics& camera, const LensDistortion& lens);

/// The depth image that a pinhole camera of the same intrinsics would have taken: each of its rays is looked
/// up in the distorted image, between four pixels where they lie on one surface, else in the nearest. Rays
/// that the distorted image does not show are NaN.
[[nodiscard]] std::vector<float> rectify(const std::vector<float>& depth_m, const CameraIntrinsics& camera,
                                         const LensDistortion& lens);

}  // namespace colift::hal
