#pragma once

#include <optional>
#include <utility>
#include <vector>

#include "perception/organised_cloud.hpp"
#include "tools/visualization/canvas.hpp"

namespace colift::picture {

/// Where things in W come to lie in the picture of a frame, drawn `scale` times as large at the canvas's
/// corner. The cloud has to outlive it.
class CameraView {
 public:
  CameraView(const perception::OrganisedCloud& cloud, int scale);

  [[nodiscard]] Box frame() const { return {0, 0, scale_ * width_, scale_ * height_}; }

  /// Nothing where the point lies behind or right before the camera.
  [[nodiscard]] std::optional<Px> at(const hal::Vec3& p_W) const;

  /// The part of a segment before the camera.
  [[nodiscard]] std::optional<std::pair<Px, Px>> segment(const hal::Vec3& from_W,
                                                         const hal::Vec3& to_W) const;

  /// 2-D covariance of the image of a point with the given covariance (px^2), to first order.
  [[nodiscard]] std::optional<Eigen::Matrix2d> spread(const hal::Vec3& p_W,
                                                      const Eigen::Matrix3d& covariance) const;

  /// Length in the picture of one metre at a point, facing the camera (px/m); 0 behind the camera.
  [[nodiscard]] double pixels_per_metre(const hal::Vec3& p_W) const;

  /// Whether the camera saw something clearly before the point.
  [[nodiscard]] bool hidden(const hal::Vec3& p_W) const;

  [[nodiscard]] hal::Vec3 camera_W() const { return X_WC_.translation(); }

  void line(Canvas& canvas, const hal::Vec3& from_W, const hal::Vec3& to_W, const Stroke& stroke) const;
  void polygon(Canvas& canvas, const std::vector<hal::Vec3>& corners_W, const Stroke& stroke) const;

 private:
  [[nodiscard]] Px image_of(const hal::Vec3& p_C) const;

  const perception::OrganisedCloud& cloud_;
  hal::CameraIntrinsics k_;
  hal::Pose X_WC_, X_CW_;
  double scale_, width_, height_;
};

/// Corners of a circle in space.
[[nodiscard]] std::vector<hal::Vec3> ring(const hal::Vec3& center, const hal::Vec3& axis, double radius);

}  // namespace colift::picture
