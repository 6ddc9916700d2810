#pragma once

#include <cstdint>
#include <limits>
#include <vector>

#include "hal/depth_camera.hpp"
#include "hal/types/geometry.hpp"

namespace colift::perception {

/// A depth image with its points in frame W. The image is the index: pixel (u, v) is entry v * width + u of
/// every array, and neighbours in the image are neighbours in the arrays. Where nothing was seen, all four
/// values are NaN.
struct OrganisedCloud {
  hal::CameraIntrinsics intrinsics;
  hal::Pose X_WC = hal::Pose::Identity();  ///< Camera optical frame C in W.
  std::vector<float> depth_m;              ///< Along Cz.
  std::vector<float> x, y, z;              ///< Point in W (m).

  [[nodiscard]] int width() const { return intrinsics.width; }
  [[nodiscard]] int height() const { return intrinsics.height; }
  [[nodiscard]] std::size_t size() const { return depth_m.size(); }
  [[nodiscard]] bool seen(std::size_t pixel) const { return depth_m[pixel] == depth_m[pixel]; }
  [[nodiscard]] hal::Vec3 point(std::size_t pixel) const { return {x[pixel], y[pixel], z[pixel]}; }

  /// Pixel of a point in W, with its depth along Cz; u and v may lie outside the image.
  struct Projection {
    double u, v, depth_m;
  };
  [[nodiscard]] Projection project(const hal::Vec3& p_W) const {
    const hal::Vec3 p_C = X_WC.inverse() * p_W;
    return {intrinsics.fx * p_C.x() / p_C.z() + intrinsics.cx,
            intrinsics.fy * p_C.y() / p_C.z() + intrinsics.cy, p_C.z()};
  }
  [[nodiscard]] bool contains(double u, double v) const {
    return u >= -0.5 && v >= -0.5 && u < width() - 0.5 && v < height() - 0.5;
  }
};

/// Points of a depth frame in W, for a camera at X_WC.
[[nodiscard]] OrganisedCloud deproject(const hal::DepthFrame& frame, const hal::Pose& X_WC);
/// The same into a cloud whose memory is kept from frame to frame.
void deproject(const hal::DepthFrame& frame, const hal::Pose& X_WC, OrganisedCloud& cloud);

}  // namespace colift::perception
