#include "perception/calibration/arm_in_view/camera_correction.hpp"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <vector>

#include "hal/types/units.hpp"
#include "perception/calibration/arm_in_view/arm_surface.hpp"

namespace colift::perception {
namespace {

using hal::Pose;
using hal::Vec3;

// Unknowns of the camera: rotation and translation of C in K, relative corrections of depth scale and focal
// length, radial distortion. Each group of points (a link, the floor) has three of its own beside them.
constexpr int kCamera = 9, kOwn = 3, kRotation = 0, kShift = 3, kDepthScale = 6, kFocal = 7, kDistortion = 8;
using CameraVector = Eigen::Matrix<double, kCamera, 1>;
using PointRow = Eigen::Matrix<double, kCamera + kOwn, 1>;
using NormalBlock = Eigen::Matrix<double, kCamera + kOwn, kCamera + kOwn>;

struct PixelPoint {
  double x, y, z;  // ray (x, y, 1) and depth, as measured
  double sigma_m;  // of the depth
};

struct Placed {
  Vec3 p_C;  // in the corrected camera, before its rotation and translation
  Vec3 p_K;  // in the calibrated camera
  Vec3 p_B;
};

Pose pose_of(const CameraVector& x) {
  Pose X = Pose::Identity();
  const Vec3 turn = x.segment<3>(kRotation);
  const double angle = turn.norm();
  if (angle > 1e-12) X.linear() = Eigen::AngleAxisd(angle, turn / angle).toRotationMatrix();
  X.translation() = x.segment<3>(kShift);
  return X;
}

/// Normal equations of one group of points.
struct PointGroup {
  NormalBlock H = NormalBlock::Zero();
  PointRow g = PointRow::Zero();
  Vec3 own = Vec3::Zero();  // its three unknowns
  Vec3 own_sigma = Vec3::Ones();

  void add(const PointRow& row, double residual, double weight) {
    H.selfadjointView<Eigen::Lower>().rankUpdate(row, weight);
    g += weight * residual * row;
  }
};

/// Tukey's weight once the fit is near, Huber's before.
double robust_weight(double residual, double sigma, double cut, bool near) {
  const double r = std::abs(residual);
  if (!near) return r > 2.0 * sigma ? 2.0 * sigma / r : 1.0;
  if (r >= cut) return 0.0;
  const double s = 1.0 - (r / cut) * (r / cut);
  return s * s;
}

class CameraFit {
 public:
  CameraFit(const hal::DepthFrame& frame, int frames, const Pose& X_BK, const ArmSurface& surface,
            const NoiseModel& noise, const CorrectionConfig& config)
      : X_BK_(X_BK),
        surface_(surface),
        config_(config),
        groups_(static_cast<std::size_t>(surface.bodies()) + 1) {
    const double turn = hal::deg_to_rad(config.rotation_sigma_deg);
    prior_.segment<3>(kRotation).setConstant(turn);
    prior_.segment<3>(kShift).setConstant(config.position_sigma_m);
    prior_[kDepthScale] = config.depth_scale_sigma;
    prior_[kFocal] = config.focal_sigma;
    prior_[kDistortion] = config.distortion_sigma;
    for (PointGroup& g : groups_) g.own_sigma.setConstant(config.link_sigma_m);
    const double tilt = hal::deg_to_rad(config.floor_tilt_sigma_deg);
    floor().own_sigma = {config.floor_sigma_m, tilt, tilt};
    collect(frame, frames, noise);
  }

  [[nodiscard]] std::size_t arm_points() const { return arm_.size(); }
  [[nodiscard]] std::size_t floor_points() const { return use_floor_ ? floor_.size() : 0; }
  [[nodiscard]] const CameraVector& x() const { return x_; }
  [[nodiscard]] const Eigen::Matrix<double, kCamera, kCamera>& covariance() const { return covariance_; }

  void run() {
    solve();
    // a floor that is not where the base's frame has it says nothing about the camera
    if (use_floor_ && std::abs(floor().own[0]) > 3.0 * config_.floor_sigma_m) {
      use_floor_ = false;
      solve();
    }
  }

  /// Root mean square distance of the arm's points from the model, of those that belong to it.
  [[nodiscard]] double residual_m(const CameraVector& x, double cut) const {
    const Pose X_KC = pose_of(x);
    double sum = 0.0;
    int n = 0;
    for (const PixelPoint& s : arm_) {
      const double d = surface_.nearest(place(s, x, X_KC).p_B).distance_m;
      if (std::abs(d) > cut) continue;
      sum += d * d;
      ++n;
    }
    return n > 0 ? std::sqrt(sum / n) : 0.0;
  }

  /// By how much a point of the corrected world is moved by a change of the unknowns.
  [[nodiscard]] Eigen::Matrix<double, 3, kCamera> moves(const Vec3& p_B) const {
    const Vec3 p = X_BK_.inverse() * p_B;
    return X_BK_.linear() * derivative(p, p);
  }

 private:
  PointGroup& floor() { return groups_.back(); }

  [[nodiscard]] Placed place(const PixelPoint& s, const CameraVector& x, const Pose& X_KC) const {
    const double r2 = s.x * s.x + s.y * s.y;
    const double lens = (1.0 - x[kDistortion] * r2) / (1.0 + x[kFocal]);
    const double z = s.z * (1.0 + x[kDepthScale]);
    Placed out;
    out.p_C = {s.x * lens * z, s.y * lens * z, z};
    out.p_K = X_KC * out.p_C;
    out.p_B = X_BK_ * out.p_K;
    return out;
  }

  [[nodiscard]] static Eigen::Matrix<double, 3, kCamera> derivative(const Vec3& p_C, const Vec3& p_K) {
    Eigen::Matrix<double, 3, kCamera> J = Eigen::Matrix<double, 3, kCamera>::Zero();
    J.col(0) = Vec3::UnitX().cross(p_K);
    J.col(1) = Vec3::UnitY().cross(p_K);
    J.col(2) = Vec3::UnitZ().cross(p_K);
    J.block<3, 3>(0, kShift).setIdentity();
    J.col(kDepthScale) = p_C;
    const Vec3 across(p_C.x(), p_C.y(), 0.0);
    J.col(kFocal) = -across;
    J.col(kDistortion) = -across * across.squaredNorm() / (p_C.z() * p_C.z());
    return J;
  }

  void collect(const hal::DepthFrame& frame, int frames, const NoiseModel& noise) {
    const auto& k = frame.intrinsics;
    if (frame.depth_m.size() != static_cast<std::size_t>(k.width) * static_cast<std::size_t>(k.height))
      return;
    const hal::Aabb around = surface_.around(0.35);
    const double average = 1.0 / std::max(1, frames);
    const auto at = [&](int u, int v) {
      return static_cast<double>(frame.depth_m[static_cast<std::size_t>(v * k.width + u)]);
    };
    const int border = config_.edge_px;
    for (int v = border; v < k.height - border; ++v)
      for (int u = border; u < k.width - border; ++u) {
        const bool of_arm = v % config_.stride == 0 && u % config_.stride == 0;
        const bool of_floor = v % config_.floor_stride == 0 && u % config_.floor_stride == 0;
        if (!of_arm && !of_floor) continue;
        const double z = at(u, v);
        if (!(z > 0.0)) continue;
        const PixelPoint s{(u - k.cx) / k.fx, (v - k.cy) / k.fy, z,
                           std::hypot(noise.sigma(z) * std::sqrt(average), 0.29 * noise.step(z) * average)};
        const Vec3 p = X_BK_ * Vec3(s.x * z, s.y * z, z);
        const bool near_arm = of_arm && p.z() >= config_.min_arm_height_m && around.contains(p);
        const bool near_floor = of_floor && std::abs(p.z()) < config_.reach_m;
        if (!near_arm && !near_floor) continue;
        // at a silhouette the depth is neither the arm's nor the background's, and the arm looks too thick
        const auto inside = [&](int edge) {
          for (int i = 1; i <= edge; ++i)
            for (const double other : {at(u - i, v), at(u + i, v), at(u, v - i), at(u, v + i)})
              if (!(std::abs(other - z) < config_.max_depth_step_m)) return false;
          return true;
        };
        if (!inside(near_arm ? config_.edge_px : 1)) continue;
        if (near_arm && std::abs(surface_.nearest(p).distance_m) < config_.reach_m) arm_.push_back(s);
        if (near_floor && std::abs(surface_.nearest(p).distance_m) > config_.reach_m) floor_.push_back(s);
      }
  }

  void solve() {
    x_.setZero();
    for (PointGroup& g : groups_) g.own.setZero();
    constexpr int kFar = 6;  // iterations with Huber's weight
    for (int i = 0; i < config_.iterations; ++i) {
      const double step = iterate(i >= kFar);
      if (i > kFar && step < 1e-6) break;
    }
  }

  /// One step of Gauss and Newton; returns its size.
  double iterate(bool near) {
    for (PointGroup& g : groups_) g.H.setZero(), g.g.setZero();
    const Pose X_KC = pose_of(x_);
    const Eigen::Matrix3d R_BK = X_BK_.linear();
    const double cut = near ? config_.cut_m : config_.reach_m;
    const auto add = [&](PointGroup& group, const PixelPoint& s, const Placed& seen, const Vec3& n_B,
                         double residual, const Vec3& own, int stride) {
      // along the ray the depth's noise counts, as far as the surface faces it
      const Vec3 n_K = R_BK.transpose() * n_B;
      const double facing = n_K.dot(seen.p_K) / seen.p_K.z();
      const double sigma = std::hypot(s.sigma_m * facing, config_.surface_sigma_m);
      // pixels of one patch are one measurement
      const double patch = std::min(
          1.0, static_cast<double>(stride * stride) / (config_.correlated_px * config_.correlated_px));
      const double weight = patch * robust_weight(residual, sigma, cut, near) / (sigma * sigma);
      if (weight <= 0.0) return;
      PointRow row;
      // at the surface, not at the measured point: else the noise of each point is a regressor of its own
      // residual, and the depths shrink (errors in variables)
      const Vec3 off_K = residual * n_K;
      row.head<kCamera>() = derivative(seen.p_C - off_K, seen.p_K - off_K).transpose() * n_K;
      row.tail<kOwn>() = own;
      group.add(row, residual, weight);
    };
    for (const PixelPoint& s : arm_) {
      const Placed seen = place(s, x_, X_KC);
      const ArmSurface::Nearest hit = surface_.nearest(seen.p_B);
      if (std::abs(hit.distance_m) > cut) continue;
      PointGroup& link = groups_[static_cast<std::size_t>(hit.body)];
      add(link, s, seen, hit.normal_B, hit.distance_m - hit.normal_B.dot(link.own), -hit.normal_B,
          config_.stride);
    }
    if (use_floor_)
      for (const PixelPoint& s : floor_) {
        const Placed seen = place(s, x_, X_KC);
        const Vec3 own(-1.0, -seen.p_B.x(), -seen.p_B.y());
        const double residual = seen.p_B.z() + own.dot(floor().own);
        if (std::abs(residual) > cut) continue;
        add(floor(), s, seen, Vec3::UnitZ(), residual, own, config_.floor_stride);
      }
    return step();
  }

  double step() {
    const auto n = static_cast<Eigen::Index>(kCamera + kOwn * groups_.size());
    Eigen::MatrixXd H = Eigen::MatrixXd::Zero(n, n);
    Eigen::VectorXd g = Eigen::VectorXd::Zero(n);
    for (int i = 0; i < kCamera; ++i) {
      const double information = 1.0 / (prior_[i] * prior_[i]);
      H(i, i) = information;
      g[i] = information * x_[i];
    }
    for (std::size_t i = 0; i < groups_.size(); ++i) {
      const PointGroup& group = groups_[i];
      const auto at = static_cast<Eigen::Index>(kCamera + kOwn * i);
      const NormalBlock full = group.H.selfadjointView<Eigen::Lower>();
      H.topLeftCorner<kCamera, kCamera>() += full.topLeftCorner<kCamera, kCamera>();
      H.block<kOwn, kCamera>(at, 0) = full.bottomLeftCorner<kOwn, kCamera>();
      H.block<kCamera, kOwn>(0, at) = full.topRightCorner<kCamera, kOwn>();
      H.block<kOwn, kOwn>(at, at) = full.bottomRightCorner<kOwn, kOwn>();
      g.head<kCamera>() += group.g.head<kCamera>();
      g.segment<kOwn>(at) = group.g.tail<kOwn>();
      for (int j = 0; j < kOwn; ++j) {
        const double information = 1.0 / (group.own_sigma[j] * group.own_sigma[j]);
        H(at + j, at + j) += information;
        g[at + j] += information * group.own[j];
      }
    }
    const Eigen::LLT<Eigen::MatrixXd> solver(H);
    const Eigen::VectorXd d = -solver.solve(g);
    x_ += d.head<kCamera>();
    for (std::size_t i = 0; i < groups_.size(); ++i)
      groups_[i].own += d.segment<kOwn>(static_cast<Eigen::Index>(kCamera + kOwn * i));
    covariance_ = solver.solve(Eigen::MatrixXd::Identity(n, n)).topLeftCorner<kCamera, kCamera>();
    return d.norm();
  }

  Pose X_BK_;
  const ArmSurface& surface_;
  const CorrectionConfig& config_;
  std::vector<PointGroup> groups_;  // one for each body of the arm, then the floor
  std::vector<PixelPoint> arm_, floor_;
  bool use_floor_ = true;
  CameraVector prior_, x_ = CameraVector::Zero();
  Eigen::Matrix<double, kCamera, kCamera> covariance_ = Eigen::Matrix<double, kCamera, kCamera>::Zero();
};

/// Root mean square shift of the workspace's corners and middle, and its standard deviation.
void judge_shift(const CameraFit& fit, const hal::Aabb& workspace_B, CameraCorrection& out) {
  double shift2 = 0.0, sigma2 = 0.0;
  std::vector<Vec3> points{workspace_B.center()};
  for (int i = 0; i < 8; ++i) points.push_back(workspace_B.corner(static_cast<hal::Aabb::CornerType>(i)));
  for (const Vec3& p : points) {
    const Eigen::Matrix<double, 3, kCamera> J = fit.moves(p);
    shift2 += (J.leftCols<kDistortion>() * fit.x().head<kDistortion>()).squaredNorm();
    // the distortion stays in the image
    sigma2 += (J * fit.covariance() * J.transpose()).trace() +
              (J.col(kDistortion) * fit.x()[kDistortion]).squaredNorm();
  }
  out.shift_m = std::sqrt(shift2 / static_cast<double>(points.size()));
  out.sigma_m = std::sqrt(sigma2 / static_cast<double>(points.size()));
}

std::string figures_of(const CameraCorrection& c) {
  return fmt::format("position {:.1f} mm, orientation {:.2f} deg, depths {:+.1f} %, focal length {:+.1f} %",
                     1e3 * c.position_m(), hal::rad_to_deg(c.rotation_rad()), 1e2 * (c.depth_scale - 1.0),
                     1e2 * (c.focal_scale - 1.0));
}

}  // namespace

double CameraCorrection::rotation_rad() const {
  return Eigen::AngleAxisd(X_KC.linear()).angle();
}

void CameraCorrection::correct(hal::DepthFrame& frame) const {
  if (!applied()) return;
  const auto scale = static_cast<float>(depth_scale);
  for (float& z : frame.depth_m) z *= scale;
  frame.intrinsics.fx *= focal_scale;
  frame.intrinsics.fy *= focal_scale;
}

CameraCorrection estimate_correction(const hal::DepthFrame& frame, int frames, const Pose& X_BK,
                                     const hal::RobotModel& robot, const hal::JointVector& q_rad,
                                     const hal::HandPosture& hand, const NoiseModel& noise,
                                     const hal::Aabb& workspace_B, const CorrectionConfig& config) {
  using Verdict = CameraCorrection::Verdict;
  CameraCorrection out;
  const ArmSurface surface(robot, q_rad, hand);
  CameraFit fit(frame, frames, X_BK, surface, noise, config);
  out.arm_points = static_cast<int>(fit.arm_points());
  if (out.arm_points * config.stride * config.stride < config.min_points) {
    out.reason = fmt::format("calibration kept: {} pixels of the arm are in view (min {})",
                             out.arm_points * config.stride * config.stride, config.min_points);
    return out;
  }
  fit.run();
  out.floor_points = static_cast<int>(fit.floor_points());
  out.X_KC = pose_of(fit.x());
  out.depth_scale = 1.0 + fit.x()[kDepthScale];
  out.focal_scale = 1.0 + fit.x()[kFocal];
  out.residual_before_m = fit.residual_m(CameraVector::Zero(), config.reach_m);
  out.residual_m = fit.residual_m(fit.x(), config.cut_m);
  judge_shift(fit, workspace_B, out);
  const bool beyond = out.shift_m > config.max_shift_m || out.position_m() > config.max_position_m ||
                      hal::rad_to_deg(out.rotation_rad()) > config.max_rotation_deg ||
                      std::abs(out.depth_scale - 1.0) > config.max_depth_scale;
  if (out.shift_m < config.min_shift_m || out.shift_m < config.min_sigmas * out.sigma_m) {
    out.reason = fmt::format("calibration kept: arm and floor agree with it to {:.0f} mm (sigma {:.0f} mm)",
                             1e3 * out.shift_m, 1e3 * out.sigma_m);
  } else if (beyond) {
    out.verdict = Verdict::Refused;
    out.reason = fmt::format(
        "arm and floor ask for a correction that moves the workspace by {:.0f} mm (at most {:.0f}): {} (at "
        "most {:.0f} mm, {:.1f} deg, {:.1f} %)",
        1e3 * out.shift_m, 1e3 * config.max_shift_m, figures_of(out), 1e3 * config.max_position_m,
        config.max_rotation_deg, 1e2 * config.max_depth_scale);
  } else if (out.residual_m > config.max_residual_m) {
    out.verdict = Verdict::Refused;
    out.reason =
        fmt::format("after a correction of {} the arm is still {:.0f} mm from its model (at most {:.0f})",
                    figures_of(out), 1e3 * out.residual_m, 1e3 * config.max_residual_m);
  } else {
    out.verdict = Verdict::Applied;
    out.reason = fmt::format(
        "camera corrected from the arm and the floor in view: {}; the workspace moves by {:.0f} mm (sigma "
        "{:.0f} mm), the arm is {:.0f} mm from its model instead of {:.0f}",
        figures_of(out), 1e3 * out.shift_m, 1e3 * out.sigma_m, 1e3 * out.residual_m,
        1e3 * out.residual_before_m);
  }
  return out;
}

}  // namespace colift::perception
