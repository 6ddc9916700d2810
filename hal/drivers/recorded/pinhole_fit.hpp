#pragma once

#include <optional>

#include "hal/depth_camera.hpp"
#include "hal/drivers/recorded/cloud_files/point_file.hpp"

namespace colift::hal {

/// The camera that took an organised cloud, found from the points themselves: pixel (u, v) must be where the
/// point (u, v) is seen.
struct PinholeFit {
  CameraIntrinsics intrinsics;
  Pose X_FC = Pose::Identity();  ///< Camera optical frame C in the file's frame F.
  double agreeing =
      0.0;  ///< Part of the points that project to less than 1 pixel from their own pixel, 0 to 1.
};

/// Fits u = fx x/z + cx and v = fy y/z + cy to the points seen from X_FC, robustly against outliers.
/// Nothing when fewer than 8 points lie before the camera, when they span no area, or when no real camera has
/// the focal length found.
[[nodiscard]] std::optional<PinholeFit> fit_pinhole(const PointFile& file, const Pose& X_FC);

/// Finds the camera's pose too, for clouds that were moved into another frame (a robot's, a map's).
/// Nothing when the points do not determine it: all in one plane, mirrored, or not taken by one camera.
/// Source: direct linear transformation, R. Hartley and A. Zisserman, Multiple View Geometry, 2nd ed.,
/// sections 6.2, 7.1.
[[nodiscard]] std::optional<PinholeFit> fit_projection(const PointFile& file);

}  // namespace colift::hal
