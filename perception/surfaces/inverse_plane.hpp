#pragma once

#include "hal/types/geometry.hpp"
#include "perception/organised_cloud.hpp"

namespace colift::perception {

/// A plane as the image sees it: inverse depth 1/z = a U + b V + c, with pixel coordinates U, V relative to a
/// fixed origin. Depth noise of structured light is nearly constant in 1/z and lies along the ray, so a plain
/// least-squares line-up in these coordinates is the right estimate also for steep and narrow faces.
struct InversePlane {
  double a = 0, b = 0, c = 0;

  [[nodiscard]] double at(double U, double V) const { return a * U + b * V + c; }
};

/// Sums over pixels from which planes follow; sets are joined by adding.
struct InverseMoments {
  double n = 0, u = 0, v = 0, q = 0, uu = 0, uv = 0, vv = 0, uq = 0, vq = 0, qq = 0;

  void add(double U, double V, double Q) {
    n += 1, u += U, v += V, q += Q;
    uu += U * U, uv += U * V, vv += V * V, uq += U * Q, vq += V * Q, qq += Q * Q;
  }
  InverseMoments& operator+=(const InverseMoments& o) {
    n += o.n, u += o.u, v += o.v, q += o.q;
    uu += o.uu, uv += o.uv, vv += o.vv, uq += o.uq, vq += o.vq, qq += o.qq;
    return *this;
  }
  InverseMoments& operator-=(const InverseMoments& o) {
    n -= o.n, u -= o.u, v -= o.v, q -= o.q;
    uu -= o.uu, uv -= o.uv, vv -= o.vv, uq -= o.uq, vq -= o.vq, qq -= o.qq;
    return *this;
  }

  /// Sum of squared residuals of these pixels to a plane.
  [[nodiscard]] double squares(const InversePlane& p) const {
    const double cross = p.a * uq + p.b * vq + p.c * q;
    const double square =
        p.a * (p.a * uu + 2 * p.b * uv + 2 * p.c * u) + p.b * (p.b * vv + 2 * p.c * v) + p.c * p.c * n;
    const double sum = qq - 2 * cross + square;
    return sum > 0 ? sum : 0;
  }
  /// Mean residual, positive where the pixels are nearer than the plane.
  [[nodiscard]] double mean_residual(const InversePlane& p) const {
    return (q - p.a * u - p.b * v) / n - p.c;
  }

  /// Plane of least squares; false, and the plane stays as it is, when the pixels lie on a line of the image.
  bool fit(InversePlane& plane) const {
    const double mu = u / n, mv = v / n, mq = q / n;
    const double cuu = uu - n * mu * mu, cuv = uv - n * mu * mv, cvv = vv - n * mv * mv;
    const double cuq = uq - n * mu * mq, cvq = vq - n * mv * mq;
    const double det = cuu * cvv - cuv * cuv;
    if (!(n >= 3 && det > 1e-6 * (cuu + cvv) * (cuu + cvv))) return false;
    plane.a = (cuq * cvv - cvq * cuv) / det;
    plane.b = (cvq * cuu - cuq * cuv) / det;
    plane.c = mq - plane.a * mu - plane.b * mv;
    return true;
  }
};

/// Between pixel coordinates with their origin at pixel (u0, v0), camera frame and W.
class ImageGeometry {
 public:
  ImageGeometry(const hal::CameraIntrinsics& k, const hal::Pose& X_WC, double u0, double v0)
      : k_(k), R_(X_WC.linear()), eye_(X_WC.translation()), u0_(u0), v0_(v0) {}

  /// Ray of a pixel in C with unit depth.
  [[nodiscard]] hal::Vec3 ray_C(double U, double V) const {
    return {(U + u0_ - k_.cx) / k_.fx, (V + v0_ - k_.cy) / k_.fy, 1.0};
  }
  [[nodiscard]] hal::Vec3 ray_W(double U, double V) const { return R_ * ray_C(U, V); }
  [[nodiscard]] hal::Vec3 point_W(double U, double V, double inverse_depth) const {
    return eye_ + ray_W(U, V) / inverse_depth;
  }
  [[nodiscard]] const hal::Vec3& eye() const { return eye_; }

  /// Plane in W with its normal towards the camera.
  [[nodiscard]] hal::Plane to_W(const InversePlane& p) const {
    const hal::Vec3 g(p.a * k_.fx, p.b * k_.fy, p.at(k_.cx - u0_, k_.cy - v0_));
    const double length = g.norm();
    const hal::Vec3 n = R_ * (-g / length);
    return {n, 1.0 / length - n.dot(eye_)};
  }
  /// The plane must not pass through the camera.
  [[nodiscard]] InversePlane from_W(const hal::Plane& plane) const {
    const hal::Vec3 g = R_.transpose() * plane.normal / -plane.height(eye_);
    return slopes(g);
  }
  /// Inverse depth that is g . ray, for a vector g in W.
  [[nodiscard]] InversePlane linear(const hal::Vec3& g_W) const { return slopes(R_.transpose() * g_W); }

  struct Pixel {
    double U, V, depth_m;
  };
  [[nodiscard]] Pixel project(const hal::Vec3& p_W) const {
    const hal::Vec3 p = R_.transpose() * (p_W - eye_);
    return {k_.fx * p.x() / p.z() + k_.cx - u0_, k_.fy * p.y() / p.z() + k_.cy - v0_, p.z()};
  }
  /// (U d, V d, d) of a vector in W, d its part along the optical axis: of points relative to the eye, this
  /// adds up like they do, and U, V are where they are seen.
  [[nodiscard]] hal::Vec3 homogeneous(const hal::Vec3& from_eye_W) const {
    const hal::Vec3 p = R_.transpose() * from_eye_W;
    return {k_.fx * p.x() + (k_.cx - u0_) * p.z(), k_.fy * p.y() + (k_.cy - v0_) * p.z(), p.z()};
  }
  [[nodiscard]] double focal() const { return 0.5 * (k_.fx + k_.fy); }

 private:
  [[nodiscard]] InversePlane slopes(const hal::Vec3& g) const {
    InversePlane p{g.x() / k_.fx, g.y() / k_.fy, 0};
    p.c = g.z() + p.a * (u0_ - k_.cx) + p.b * (v0_ - k_.cy);
    return p;
  }

  hal::CameraIntrinsics k_;
  Eigen::Matrix3d R_;
  hal::Vec3 eye_;
  double u0_, v0_;
};

}  // namespace colift::perception
