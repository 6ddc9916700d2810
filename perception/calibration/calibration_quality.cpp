// What a set of poses and a solution are worth.

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "hal/types/symmetric.hpp"
#include "hal/types/units.hpp"
#include "perception/calibration/calibrate.hpp"

namespace colift::perception {
namespace {

// spreads at which more of them hardly helps (docs/calibration.md)
constexpr double kGoodRotation_deg = 20.0, kGoodPosition_m = 0.10;

/// Standard deviations along the principal axes, largest first.
Vec3 spread(const std::vector<Vec3>& points) {
  if (points.empty()) return Vec3::Zero();
  Vec3 mean = Vec3::Zero();
  for (const Vec3& p : points) mean += p;
  mean /= static_cast<double>(points.size());
  Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
  for (const Vec3& p : points) sum += (p - mean) * (p - mean).transpose();
  const hal::SmallVector values = hal::small_symmetric_eigen(sum / static_cast<double>(points.size())).values;
  return values.cwiseMax(0.0).cwiseSqrt().reverse();
}

}  // namespace

PoseDiversity diversity_of(std::span<const EmitterSample> samples, std::span<const int> use,
                           const Vec3& p_H) {
  PoseDiversity out;
  if (use.empty()) return out;
  // the mean rotation is the quaternion nearest to all, up to their sign (Markley 2007)
  Eigen::Matrix4d sum = Eigen::Matrix4d::Zero();
  for (const int i : use) {
    const Eigen::Quaterniond q(samples[static_cast<std::size_t>(i)].X_BH.linear());
    sum += q.coeffs() * q.coeffs().transpose();
  }
  const Eigen::Quaterniond mean(Eigen::Vector4d(hal::small_symmetric_eigen(sum).vectors.col(3)));
  std::vector<Vec3> turns, places;
  for (const int i : use) {
    const EmitterSample& s = samples[static_cast<std::size_t>(i)];
    const Eigen::AngleAxisd turn(mean.inverse() * Eigen::Quaterniond(s.X_BH.linear()));
    const double angle = turn.angle() > std::numbers::pi ? turn.angle() - 2 * std::numbers::pi : turn.angle();
    turns.push_back((angle * turn.axis()).unaryExpr(&hal::rad_to_deg));
    places.push_back(s.X_BH * p_H);
  }
  out.rotation_deg = spread(turns);
  out.position_m = spread(places);
  const double rotation = std::min(1.0, out.rotation_deg[1] / kGoodRotation_deg);
  const double position = std::min(1.0, out.position_m[2] / kGoodPosition_m);
  out.score = std::sqrt(rotation * position);
  return out;
}

std::vector<Vec3> workspace_grid(const CalibrationConfig& config) {
  std::vector<Vec3> points;
  for (const double x : {-0.5, 0.0, 0.5})
    for (const double y : {-0.5, 0.0, 0.5})
      for (const double z : {-0.5, 0.5})
        points.push_back(config.workspace_center_m + config.workspace_size_m.cwiseProduct(Vec3(x, y, z)));
  return points;
}

PlacingError placing_error(const EmitterModel& model, const Eigen::Matrix<double, 6, 6>& covariance,
                           std::span<const Vec3> points_B) {
  PlacingError out;
  double sum = 0.0;
  for (const Vec3& p : points_B) {
    const Eigen::Matrix<double, 3, 6> D = placing_jacobian(model, p);
    const double square = (D * covariance * D.transpose()).trace();
    sum += square;
    out.worst_m = std::max(out.worst_m, std::sqrt(std::max(square, 0.0)));
  }
  if (!points_B.empty()) out.rms_m = std::sqrt(std::max(sum, 0.0) / static_cast<double>(points_B.size()));
  return out;
}

}  // namespace colift::perception
