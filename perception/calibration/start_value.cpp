#include "perception/calibration/start_value.hpp"

#include <Eigen/Geometry>
#include <cmath>
#include <vector>

#include "hal/types/symmetric.hpp"

namespace colift::perception {
namespace {

using Mat3 = Eigen::Matrix3d;
using Mat6 = Eigen::Matrix<double, 6, 6>;
using Vec6 = Eigen::Matrix<double, 6, 1>;

/// One ray with the pose of the palm.
struct Ray {
  Mat3 along;  // projector onto the ray
  Vec3 direction;
  const Pose* X_BH;
};

/// The rotation that turns vectors a into vectors b best, from the sum of b a^T (Horn 1987, by quaternion).
Mat3 nearest_rotation(const Mat3& sum) {
  const Mat3 m = sum.transpose();
  Eigen::Matrix4d n;
  n << m.trace(), m(1, 2) - m(2, 1), m(2, 0) - m(0, 2), m(0, 1) - m(1, 0),   //
      0, m(0, 0) - m(1, 1) - m(2, 2), m(0, 1) + m(1, 0), m(2, 0) + m(0, 2),  //
      0, 0, -m(0, 0) + m(1, 1) - m(2, 2), m(1, 2) + m(2, 1),                 //
      0, 0, 0, -m(0, 0) - m(1, 1) + m(2, 2);
  const Eigen::Vector4d q = hal::small_symmetric_eigen(n.transpose()).vectors.col(3);  // reads the lower half
  return Eigen::Quaterniond(q[0], q[1], q[2], q[3]).normalized().toRotationMatrix();
}

/// Translation and emitter that bring the points nearest to their rays, for a rotation.
void solve_linear(const std::vector<Ray>& rays, const Vec3& prior, double prior_m, EmitterModel& model) {
  Mat6 H = Mat6::Zero();
  Vec6 g = Vec6::Zero();
  for (const Ray& ray : rays) {
    const Mat3 off = Mat3::Identity() - ray.along;  // a projector: off^T off = off
    const Mat3 turn = model.R_CB * ray.X_BH->linear();
    const Vec3 known = off * (model.R_CB * ray.X_BH->translation());
    H.topLeftCorner<3, 3>() += off;
    H.topRightCorner<3, 3>() += off * turn;
    H.bottomRightCorner<3, 3>() += turn.transpose() * off * turn;
    g.head<3>() -= known;
    g.tail<3>() -= turn.transpose() * known;
  }
  H.bottomLeftCorner<3, 3>() = H.topRightCorner<3, 3>().transpose();
  // the prior as so many points that are a centimetre off their rays
  const double weight = 1e-4 / (prior_m * prior_m) * static_cast<double>(rays.size()) / 7.0;
  H.bottomRightCorner<3, 3>().diagonal().array() += weight;
  g.tail<3>() += weight * prior;
  const Vec6 x = hal::solve_symmetric<double, 6>(H, g);
  model.t_CB = x.head<3>();
  model.p_H = x.tail<3>();
}

}  // namespace

bool start_value(std::span<const EmitterSample> samples, std::span<const int> use, double emitter_prior_m,
                 int rounds, EmitterModel& model) {
  if (use.size() < 4) return false;
  const auto& k = model.camera;
  const Vec3 prior = model.p_H;
  std::vector<Ray> rays;
  Vec3 mean_x = Vec3::Zero(), mean_n = Vec3::Zero();
  for (const int i : use) {
    const EmitterSample& s = samples[static_cast<std::size_t>(i)];
    const Vec3 n((s.pixel.x() - k.cx) / k.fx, (s.pixel.y() - k.cy) / k.fy, 1.0);
    rays.push_back({n * n.transpose() / n.squaredNorm(), n, &s.X_BH});
    mean_x += s.X_BH * model.p_H;
    mean_n += n;
  }
  const auto count = static_cast<double>(rays.size());
  mean_x /= count;
  mean_n /= count;
  // scaled orthography: the image is the points' first two coordinates, up to a factor
  Eigen::Matrix<double, 2, 3> A = Eigen::Matrix<double, 2, 3>::Zero();
  Mat3 spread = Mat3::Zero();
  for (const Ray& ray : rays) {
    const Vec3 x = *ray.X_BH * model.p_H - mean_x;
    A += (ray.direction - mean_n).head<2>() * x.transpose();
    spread += x * x.transpose();
  }
  spread.diagonal().array() += 1e-4 * spread.trace() + 1e-12;
  const Eigen::Matrix<double, 2, 3> rows = A * spread.inverse();
  const double scale = 0.5 * (rows.row(0).norm() + rows.row(1).norm());
  if (!(scale > 1e-6)) return false;
  Mat3 first;
  first.row(0) = rows.row(0) / scale;
  first.row(1) = rows.row(1) / scale;
  first.row(2) = first.row(0).cross(first.row(1));
  model.R_CB = nearest_rotation(first);

  for (int round = 0; round < rounds; ++round) {
    solve_linear(rays, prior, emitter_prior_m, model);
    Vec3 mean_y = Vec3::Zero();
    mean_x.setZero();
    std::vector<Vec3> foot, x;
    for (const Ray& ray : rays) {
      x.push_back(*ray.X_BH * model.p_H);
      foot.push_back(ray.along * (model.R_CB * x.back() + model.t_CB));
      mean_x += x.back();
      mean_y += foot.back();
    }
    mean_x /= count;
    mean_y /= count;
    Mat3 sum = Mat3::Zero();
    for (std::size_t i = 0; i < x.size(); ++i) sum += (foot[i] - mean_y) * (x[i] - mean_x).transpose();
    if (!sum.allFinite()) return false;
    model.R_CB = nearest_rotation(sum);
  }
  solve_linear(rays, prior, emitter_prior_m, model);
  int behind = 0;
  for (const Ray& ray : rays) behind += (model.in_camera(*ray.X_BH)).z() <= 0.05 ? 1 : 0;
  return behind == 0 && model.t_CB.allFinite() && model.p_H.allFinite();
}

}  // namespace colift::perception
