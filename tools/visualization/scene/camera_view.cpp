#include "tools/visualization/scene/camera_view.hpp"

#include <cmath>
#include <numbers>

namespace colift::picture {
namespace {

constexpr double kNear_m = 0.05;

}  // namespace

CameraView::CameraView(const perception::OrganisedCloud& cloud, int scale)
    : cloud_(cloud),
      k_(cloud.intrinsics),
      X_WC_(cloud.X_WC),
      X_CW_(cloud.X_WC.inverse()),
      scale_(scale),
      width_(cloud.width()),
      height_(cloud.height()) {}

// The centre of a frame's pixel is the middle of its square in the picture.
Px CameraView::image_of(const hal::Vec3& p_C) const {
  return {scale_ * (k_.fx * p_C.x() / p_C.z() + k_.cx + 0.5),
          scale_ * (k_.fy * p_C.y() / p_C.z() + k_.cy + 0.5)};
}

std::optional<Px> CameraView::at(const hal::Vec3& p_W) const {
  const hal::Vec3 p_C = X_CW_ * p_W;
  if (!(p_C.z() > kNear_m)) return std::nullopt;
  return image_of(p_C);
}

std::optional<std::pair<Px, Px>> CameraView::segment(const hal::Vec3& from_W, const hal::Vec3& to_W) const {
  hal::Vec3 a = X_CW_ * from_W, b = X_CW_ * to_W;
  if (!(a.z() > kNear_m) && !(b.z() > kNear_m)) return std::nullopt;
  if (!(a.z() > kNear_m))
    a = b + (b.z() - kNear_m) / (b.z() - a.z()) * (a - b);
  else if (!(b.z() > kNear_m))
    b = a + (a.z() - kNear_m) / (a.z() - b.z()) * (b - a);
  return std::pair{image_of(a), image_of(b)};
}

std::optional<Eigen::Matrix2d> CameraView::spread(const hal::Vec3& p_W,
                                                  const Eigen::Matrix3d& covariance) const {
  const hal::Vec3 p = X_CW_ * p_W;
  if (!(p.z() > kNear_m) || !covariance.allFinite()) return std::nullopt;
  Eigen::Matrix<double, 2, 3> jacobian;
  jacobian << k_.fx / p.z(), 0, -k_.fx * p.x() / (p.z() * p.z()),  //
      0, k_.fy / p.z(), -k_.fy * p.y() / (p.z() * p.z());
  const Eigen::Matrix<double, 2, 3> j = scale_ * jacobian * X_CW_.linear();
  return j * covariance * j.transpose();
}

bool CameraView::hidden(const hal::Vec3& p_W) const {
  constexpr double kClearly_m = 0.04;
  const auto at = cloud_.project(p_W);
  if (!(at.depth_m > kNear_m) || !cloud_.contains(at.u, at.v)) return false;
  const auto pixel = static_cast<std::size_t>(std::lround(at.v) * cloud_.width() + std::lround(at.u));
  return cloud_.seen(pixel) && static_cast<double>(cloud_.depth_m[pixel]) < at.depth_m - kClearly_m;
}

double CameraView::pixels_per_metre(const hal::Vec3& p_W) const {
  const double z = (X_CW_ * p_W).z();
  return z > kNear_m ? scale_ * k_.fx / z : 0.0;
}

void CameraView::line(Canvas& canvas, const hal::Vec3& from_W, const hal::Vec3& to_W,
                      const Stroke& stroke) const {
  if (const auto ends = segment(from_W, to_W)) canvas.line(ends->first, ends->second, stroke);
}

void CameraView::polygon(Canvas& canvas, const std::vector<hal::Vec3>& corners_W,
                         const Stroke& stroke) const {
  std::vector<Px> points;
  for (const hal::Vec3& p : corners_W) {
    const auto px = at(p);
    if (!px) {  // partly behind the camera: each side on its own
      for (std::size_t i = 0; i < corners_W.size(); ++i)
        line(canvas, corners_W[i], corners_W[(i + 1) % corners_W.size()], stroke);
      return;
    }
    points.push_back(*px);
  }
  canvas.polyline(points, true, stroke);
}

std::vector<hal::Vec3> ring(const hal::Vec3& center, const hal::Vec3& axis, double radius) {
  constexpr int kCorners = 48;
  const auto [u, v] = hal::tangents(axis.normalized());
  std::vector<hal::Vec3> points;
  for (int i = 0; i < kCorners; ++i) {
    const double angle = 2 * std::numbers::pi * i / kCorners;
    points.push_back(center + radius * (std::cos(angle) * u + std::sin(angle) * v));
  }
  return points;
}

}  // namespace colift::picture
