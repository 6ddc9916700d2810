#include "perception/calibration/emitter_model.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

#include "hal/types/symmetric.hpp"

namespace colift::perception {
namespace {

static_assert(kAllParameters <= hal::SmallVector::MaxRowsAtCompileTime);  // or they could not be solved for

constexpr double kHuber = 1.5;       // in standard deviations of a sample; beyond, it counts linearly (Huber)
constexpr double kNearest_m = 0.05;  // nothing is seen nearer to the camera

// Standard deviations of the priors of released intrinsics and depth, about what the camera reports: they
// keep a solution from few poses from running away.
constexpr double kFocal_px = 6.0, kCentre_px = 4.0, kScale = 0.01, kOffset_m = 0.01;

Eigen::Matrix3d cross(const Vec3& v) {
  Eigen::Matrix3d m;
  m << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
  return m;
}

Eigen::Matrix3d rotation(const Vec3& w) {
  const double angle = w.norm();
  if (angle < 1e-12) return Eigen::Matrix3d::Identity() + cross(w);
  return Eigen::AngleAxisd(angle, w / angle).toRotationMatrix();
}

EmitterModel moved(const EmitterModel& model, const Step& d) {
  EmitterModel out = model;
  out.R_CB = rotation(d.head<3>()) * model.R_CB;
  out.t_CB += d.segment<3>(3);
  out.p_H += d.segment<3>(6);
  if (d.size() == kAllParameters) {
    const double ratio = model.camera.fy / model.camera.fx;
    out.camera.fx += d[9];
    out.camera.fy = out.camera.fx * ratio;
    out.camera.cx += d[10];
    out.camera.cy += d[11];
    out.depth_scale += d[12];
    out.depth_offset_m += d[13];
  }
  return out;
}

/// Adds one row J x = r of unit weight.
class Sum {
 public:
  Sum(Linearised& out, int n) : out_(out), n_(n) {
    out.H = Normal::Zero(n, n);
    out.g = Step::Zero(n);
  }
  void add(const Step& row, double residual, double weight) {
    out_.H.noalias() += weight * row * row.transpose();
    out_.g.noalias() += weight * residual * row;
    ++out_.rows;
  }
  void add_prior(int parameter, double off, double sigma) {
    Step row = Step::Zero(n_);
    row[parameter] = 1.0 / sigma;
    add(row, off / sigma, 1.0);
    out_.cost += off * off / (sigma * sigma);
  }

 private:
  Linearised& out_;
  int n_;
};

}  // namespace

double pixel_sigma(const EmitterSample& sample, const EmitterModel& model, double z_m,
                   const EmitterNoise& noise) {
  const double spot = std::max(0.5 * sample.covariance.trace(), noise.pixel_px * noise.pixel_px);
  const double arm = model.camera.fx * noise.arm_m / std::max(z_m, kNearest_m);
  return std::sqrt(spot + arm * arm);
}

double depth_sigma(double z_m) {
  return 0.0012 + 0.0019 * (z_m - 0.4) * (z_m - 0.4);
}

Eigen::Vector2d pixel_residual(const EmitterSample& sample, const EmitterModel& model) {
  const Vec3 y = model.in_camera(sample.X_BH);
  if (y.z() < kNearest_m) return Eigen::Vector2d::Constant(std::numeric_limits<double>::infinity());
  return Eigen::Vector2d(model.camera.fx * y.x() / y.z() + model.camera.cx,
                         model.camera.fy * y.y() / y.z() + model.camera.cy) -
         sample.pixel;
}

Linearised linearise(std::span<const EmitterSample> samples, const EmitterModel& model,
                     const EmitterModel& prior, const EmitterRows& rows, const EmitterNoise& noise) {
  Linearised out;
  const int n = rows.released != Released::Nothing ? kAllParameters : kPoseParameters;
  Sum sum(out, n);
  const auto& k = model.camera;
  const double ratio = k.fy / k.fx;
  for (const int i : rows.samples) {
    const EmitterSample& s = samples[static_cast<std::size_t>(i)];
    const Vec3 x_B = s.X_BH * model.p_H;
    const Vec3 turned = model.R_CB * x_B;
    const Vec3 y = turned + model.t_CB;
    if (!(y.z() >= kNearest_m)) {
      out.cost = std::numeric_limits<double>::infinity();
      return out;
    }
    // the point in C against rotation, translation and emitter
    Eigen::Matrix<double, 3, kPoseParameters> dy;
    dy.leftCols<3>() = -cross(turned);
    dy.middleCols<3>(3).setIdentity();
    dy.rightCols<3>() = model.R_CB * s.X_BH.linear();

    const double u = y.x() / y.z(), v = y.y() / y.z();
    const Eigen::Vector2d r(k.fx * u + k.cx - s.pixel.x(), k.fy * v + k.cy - s.pixel.y());
    const double sigma = pixel_sigma(s, model, y.z(), noise);
    Step row_u = Step::Zero(n), row_v = Step::Zero(n);
    row_u.head<kPoseParameters>() = (k.fx / y.z() * (dy.row(0) - u * dy.row(2))).transpose();
    row_v.head<kPoseParameters>() = (k.fy / y.z() * (dy.row(1) - v * dy.row(2))).transpose();
    if (rows.released == Released::Intrinsics) {
      row_u[9] = u, row_u[10] = 1.0;
      row_v[9] = ratio * v, row_v[11] = 1.0;
    }
    const double e = r.norm() / sigma;
    double weight = 1.0, cost = e * e;
    if (rows.huber && e > kHuber) {
      weight = kHuber / e;
      cost = 2.0 * kHuber * e - kHuber * kHuber;
    }
    sum.add(row_u / sigma, r.x() / sigma, weight);
    sum.add(row_v / sigma, r.y() / sigma, weight);
    out.cost += cost;

    if (!rows.use_depth.empty() && rows.use_depth[static_cast<std::size_t>(i)] && s.depth_m) {
      const double sigma_z = std::hypot(depth_sigma(y.z()), noise.arm_m);
      const double rz = model.depth_scale * y.z() + model.depth_offset_m - *s.depth_m;
      Step row = Step::Zero(n);
      row.head<kPoseParameters>() = model.depth_scale * dy.row(2).transpose();
      if (rows.released != Released::Nothing) row[12] = y.z(), row[13] = 1.0;
      const double ez = std::abs(rz) / sigma_z;
      const bool far = rows.huber && ez > kHuber;
      sum.add(row / sigma_z, rz / sigma_z, far ? kHuber / ez : 1.0);
      out.cost += far ? 2.0 * kHuber * ez - kHuber * kHuber : ez * ez;
    }
  }
  if (rows.emitter_prior_m > 0.0)
    for (int a = 0; a < 3; ++a) sum.add_prior(6 + a, model.p_H[a] - prior.p_H[a], rows.emitter_prior_m);
  if (rows.released != Released::Nothing) {
    // parameters that are not released have no rows but these, so they stay
    sum.add_prior(9, k.fx - prior.camera.fx, kFocal_px);
    sum.add_prior(10, k.cx - prior.camera.cx, kCentre_px);
    sum.add_prior(11, k.cy - prior.camera.cy, kCentre_px);
    sum.add_prior(12, model.depth_scale - prior.depth_scale, kScale);
    sum.add_prior(13, model.depth_offset_m - prior.depth_offset_m, kOffset_m);
  }
  return out;
}

double refine(std::span<const EmitterSample> samples, const EmitterRows& rows, const EmitterNoise& noise,
              const EmitterModel& prior, int most_steps, EmitterModel& model) {
  double lambda = 1e-3;
  Linearised at = linearise(samples, model, prior, rows, noise);
  for (int step = 0; step < most_steps && std::isfinite(at.cost); ++step) {
    Normal damped = at.H;
    damped.diagonal() += lambda * (at.H.diagonal().array() + 1e-9).matrix();
    const Step d = hal::solve_small_symmetric(damped, -at.g);
    if (!d.allFinite()) break;
    const EmitterModel next = moved(model, d);
    Linearised there = linearise(samples, next, prior, rows, noise);
    if (there.cost <= at.cost) {
      const bool still = d.norm() < 1e-13 || at.cost - there.cost < 1e-14 * at.cost;
      model = next;
      at = std::move(there);
      lambda = std::max(lambda * 0.2, 1e-12);
      if (still) break;
    } else {
      lambda *= 6.0;
      if (lambda > 1e9) break;
    }
  }
  // products of many small rotations drift from being one
  model.R_CB = Eigen::Quaterniond(model.R_CB).normalized().toRotationMatrix();
  return at.cost;
}

Eigen::Matrix<double, 3, 6> placing_jacobian(const EmitterModel& model, const Vec3& p_B) {
  // p = R^T (y - t) with y fixed and R <- exp(w) R, so dp = R^T [y - t]x w - R^T dt
  Eigen::Matrix<double, 3, 6> D;
  D.leftCols<3>() = model.R_CB.transpose() * cross(model.R_CB * p_B);
  D.rightCols<3>() = -model.R_CB.transpose();
  return D;
}

}  // namespace colift::perception
