#include "perception/views/view_alignment.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

#include "hal/types/units.hpp"

namespace colift::perception {
namespace {

using hal::Pose;
using hal::Vec3;
using Matrix6 = Eigen::Matrix<double, 6, 6>;
using Vector6 = Eigen::Matrix<double, 6, 1>;

constexpr int kSpan_px = 3;     // of the differences that a normal is made from
constexpr double kJump = 0.06;  // depth difference over them, as a fraction of the depth: an edge
constexpr double kTukeySigmas = 4.0;
constexpr double kConverged_m = 2e-5;

/// Unit normal towards the camera; nothing at edges and holes.
std::optional<Vec3> normal_at(const OrganisedCloud& cloud, int u, int v) {
  if (u < kSpan_px || v < kSpan_px || u >= cloud.width() - kSpan_px || v >= cloud.height() - kSpan_px)
    return std::nullopt;
  const auto at = [&](int du, int dv) {
    return static_cast<std::size_t>(v + dv) * static_cast<std::size_t>(cloud.width()) +
           static_cast<std::size_t>(u + du);
  };
  const std::size_t around[4] = {at(-kSpan_px, 0), at(kSpan_px, 0), at(0, -kSpan_px), at(0, kSpan_px)};
  const double here_m = cloud.depth_m[at(0, 0)];
  for (const std::size_t p : around)
    if (!(std::abs(cloud.depth_m[p] - here_m) < kJump * here_m)) return std::nullopt;
  const Vec3 normal = (cloud.point(around[1]) - cloud.point(around[0]))
                          .cross(cloud.point(around[3]) - cloud.point(around[2]));
  const double length = normal.norm();
  if (!(length > 0.0)) return std::nullopt;
  const Vec3 to_camera = cloud.X_WC.translation() - cloud.point(at(0, 0));
  return Vec3(normal * ((normal.dot(to_camera) < 0.0 ? -1.0 : 1.0) / length));
}

struct Sample {
  Vec3 point, normal;
  double sigma_m;  // of the point along its normal
};

double sigma_along(const OrganisedCloud& cloud, const Vec3& point, const Vec3& normal, double depth_m,
                   const NoiseModel& noise) {
  const Vec3 ray = (point - cloud.X_WC.translation()).normalized();
  return noise.sigma(depth_m) * std::abs(ray.dot(normal));
}

class Alignment {
 public:
  Alignment(const OrganisedCloud& fixed, const OrganisedCloud& moving, const NoiseModel& noise,
            const AlignmentConfig& config)
      : fixed_(fixed), noise_(noise), c_(config) {
    for (int v = 0; v < moving.height(); v += c_.stride)
      for (int u = 0; u < moving.width(); u += c_.stride) {
        const auto p = static_cast<std::size_t>(v) * static_cast<std::size_t>(moving.width()) +
                       static_cast<std::size_t>(u);
        if (!moving.seen(p)) continue;
        const auto normal = normal_at(moving, u, v);
        if (!normal) continue;
        const Vec3 point = moving.point(p);
        samples_.push_back({point, *normal, sigma_along(moving, point, *normal, moving.depth_m[p], noise)});
      }
    X_FW_ = fixed.X_WC.inverse();
    eye_ = moving.X_WC.translation();
  }

  ViewAlignment run() {
    ViewAlignment out;
    Pose X = Pose::Identity();
    // the gate closes as the views come together
    double gate_m = c_.gate_m;
    match(X, gate_m);
    out.points = static_cast<int>(pairs_.size());
    out.receded = static_cast<double>(behind_) / std::max<double>(1.0, static_cast<double>(samples_.size()));
    out.before_m = median_distance();
    if (out.points < c_.min_points) {
      out.reason = fmt::format("the views show {} points in common, expected {}", out.points, c_.min_points);
      return out;
    }
    Matrix6 information = Matrix6::Zero();  // with the prior's
    for (int n = 0; n < c_.iterations; ++n) {
      const double step_m = improve(X, information);
      gate_m = std::max(0.5 * c_.gate_m, 0.8 * gate_m);
      match(X, gate_m);
      if (pairs_.size() < static_cast<std::size_t>(c_.min_points) || step_m < kConverged_m) break;
    }
    out.points = static_cast<int>(pairs_.size());
    out.after_m = median_distance();
    out.X = X;
    const Matrix6 covariance = information.inverse();
    const Vector6 moved = motion(X);
    information.diagonal() -= prior();
    out.sigmas = std::sqrt(std::max(0.0, moved.dot(information * moved)));
    double shift = 0.0, rest = 0.0;
    for (const Pair& pair : pairs_) {
      const Vec3& p = samples_[pair.sample].point;
      shift += (X * p - p).squaredNorm();
      rest += moved_covariance(p, covariance);
    }
    const double n = std::max<double>(1.0, static_cast<double>(pairs_.size()));
    out.shift_m = std::sqrt(shift / n);
    out.sigma_m = std::sqrt(rest / n);
    out.enough = out.points >= c_.min_points;
    out.reason = fmt::format(
        "{} points in common, {:.1f} mm apart, {:.1f} mm after {:.0f} mm and {:.2f} deg of alignment "
        "({:.1f} standard deviations)",
        out.points, 1e3 * out.before_m, 1e3 * out.after_m, 1e3 * (X * eye_ - eye_).norm(),
        hal::rad_to_deg(out.rotation_rad()), out.sigmas);
    return out;
  }

 private:
  struct Pair {
    std::size_t sample;
    Vec3 point, normal;  // of the fixed view
    double sigma_m, distance_m;
  };

  void match(const Pose& X, double gate_m) {
    pairs_.clear();
    behind_ = 0;
    const double min_cos = std::cos(hal::deg_to_rad(c_.max_normal_deg));
    const auto& k = fixed_.intrinsics;
    for (std::size_t s = 0; s < samples_.size(); ++s) {
      const Vec3 p = X * samples_[s].point, p_F = X_FW_ * p;
      if (p_F.z() < 0.1) continue;
      const int u = static_cast<int>(std::lround(k.fx * p_F.x() / p_F.z() + k.cx)),
                v = static_cast<int>(std::lround(k.fy * p_F.y() / p_F.z() + k.cy));
      if (u < 0 || v < 0 || u >= k.width || v >= k.height) continue;
      const auto pixel =
          static_cast<std::size_t>(v) * static_cast<std::size_t>(k.width) + static_cast<std::size_t>(u);
      if (!fixed_.seen(pixel)) continue;
      const Vec3 q = fixed_.point(pixel);
      behind_ += p_F.z() > fixed_.depth_m[pixel] + gate_m;
      if ((q - p).norm() > 2.0 * gate_m) continue;
      const auto normal = normal_at(fixed_, u, v);
      if (!normal || normal->dot(X.linear() * samples_[s].normal) < min_cos) continue;
      const double distance_m = normal->dot(p - q);
      if (std::abs(distance_m) > gate_m) continue;
      const double of_fixed = sigma_along(fixed_, q, *normal, fixed_.depth_m[pixel], noise_);
      pairs_.push_back({s, q, *normal,
                        std::sqrt(of_fixed * of_fixed + samples_[s].sigma_m * samples_[s].sigma_m +
                                  c_.surface_sigma_m * c_.surface_sigma_m),
                        distance_m});
    }
  }

  [[nodiscard]] double median_distance() const {
    if (pairs_.empty()) return NAN;
    std::vector<double> d;
    d.reserve(pairs_.size());
    for (const Pair& pair : pairs_) d.push_back(std::abs(pair.distance_m));
    const auto middle = d.begin() + static_cast<std::ptrdiff_t>(d.size() / 2);
    std::nth_element(d.begin(), middle, d.end());
    return *middle;
  }

  /// One Gauss-Newton step about the moving camera's place; returns how far it moved the points.
  double improve(Pose& X, Matrix6& information) const {
    // what is left after a bad start is no noise: its spread sets the scale
    const double scale = std::max(1.0, 1.5 * median_distance() / typical_sigma());
    const double patch = static_cast<double>(c_.stride) / c_.correlated_px;
    const double alone = std::min(1.0, patch * patch);
    Matrix6 A = Matrix6::Zero();
    Vector6 b = Vector6::Zero();
    for (const Pair& pair : pairs_) {
      const double e = pair.distance_m / (scale * pair.sigma_m * kTukeySigmas);
      if (std::abs(e) >= 1.0) continue;
      const double root = 1.0 - e * e;
      const double weight = alone * root * root / (scale * scale * pair.sigma_m * pair.sigma_m);
      Vector6 j;
      j << pair.normal, (X * samples_[pair.sample].point - eye_).cross(pair.normal);
      A += weight * j * j.transpose();
      b -= weight * pair.distance_m * j;
    }
    A.diagonal() += prior();
    // the prior holds the camera where it was, not where the last step took it
    b -= prior().cwiseProduct(motion(X));
    const Vector6 step = A.ldlt().solve(b);
    information = A;
    Pose update = Pose::Identity();
    const Vec3 turn = step.tail<3>();
    if (turn.norm() > 0.0) update.linear() = Eigen::AngleAxisd(turn.norm(), turn.normalized()).matrix();
    update.translation() = eye_ + step.head<3>() - update.linear() * eye_;
    X = update * X;
    return step.head<3>().norm() + 2.0 * turn.norm();
  }

  /// Inverse variances of the motion before anything was seen.
  [[nodiscard]] Vector6 prior() const {
    const double per_m = 1.0 / c_.position_sigma_m, per_rad = 1.0 / hal::deg_to_rad(c_.rotation_sigma_deg);
    Vector6 out;
    out << Vec3::Constant(per_m * per_m), Vec3::Constant(per_rad * per_rad);
    return out;
  }

  /// Shift of the moving camera's place, and rotation vector.
  [[nodiscard]] Vector6 motion(const Pose& X) const {
    const Eigen::AngleAxisd turned(X.linear());
    Vector6 out;
    out << X * eye_ - eye_, turned.angle() * turned.axis();
    return out;
  }

  [[nodiscard]] double typical_sigma() const {
    double sum = 0.0;
    for (const Pair& pair : pairs_) sum += pair.sigma_m;
    return sum / std::max<double>(1.0, static_cast<double>(pairs_.size()));
  }

  [[nodiscard]] double moved_covariance(const Vec3& p, const Matrix6& covariance) const {
    Eigen::Matrix<double, 3, 6> j;
    const Vec3 r = p - eye_;
    j << Eigen::Matrix3d::Identity(),
        (Eigen::Matrix3d() << 0, r.z(), -r.y(), -r.z(), 0, r.x(), r.y(), -r.x(), 0).finished();
    return (j * covariance * j.transpose()).trace();
  }

  const OrganisedCloud& fixed_;
  const NoiseModel& noise_;
  const AlignmentConfig& c_;
  Pose X_FW_;
  Vec3 eye_;
  std::vector<Sample> samples_;
  std::vector<Pair> pairs_;
  std::size_t behind_ = 0;
};

}  // namespace

ViewAlignment align_views(const OrganisedCloud& fixed, const OrganisedCloud& moving, const NoiseModel& noise,
                          const AlignmentConfig& config) {
  return Alignment(fixed, moving, noise, config).run();
}

}  // namespace colift::perception
