#include "perception/motion/object_motion.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "hal/types/symmetric.hpp"
#include "hal/types/units.hpp"
namespace colift::perception {
namespace {

using hal::ErrorCode;
using hal::failure;
using hal::Pose;
using hal::Vec3;
using Twist = Eigen::Matrix<double, 6, 1>;
using Information = Eigen::Matrix<double, 6, 6>;

constexpr double kSettled_m = 2e-5;  // far below the noise: a smaller correction ends the iteration
// A turn of 1 rad weighs as much as this shift. Longer than the objects: where the view cannot tell a turn
// from a shift (a pipe that rolls or slides), the shift is believed.
constexpr double kTurn_m = 1.0;

Eigen::Matrix3d cross_matrix(const Vec3& a) {
  Eigen::Matrix3d m;
  m << 0, -a.z(), a.y(), a.z(), 0, -a.x(), -a.y(), a.x(), 0;
  return m;
}

// sums over the samples of one alignment step
struct Sums {
  Information information = Information::Zero();
  Twist right = Twist::Zero();
  double weight = 0.0, squares = 0.0;
  std::size_t found = 0, nearer = 0, farther = 0, unseen = 0, outside = 0;
};

// the object's motion in C: turn about its middle, then shift
struct Motion {
  Eigen::Matrix3d turn = Eigen::Matrix3d::Identity();
  Vec3 shift = Vec3::Zero();
};

Vec3 rotation_vector(const Eigen::Matrix3d& R) {
  const Eigen::AngleAxisd a(R);
  return a.angle() * a.axis();
}

}  // namespace

double ObjectMotion::tilt(const Vec3& up) const {
  const Vec3 now = X_WTnow_WTref.linear() * up;
  return std::atan2(up.cross(now).norm(), up.dot(now));
}

double ObjectMotion::rise_sigma(const Vec3& up) const {
  return std::sqrt(up.dot(covariance.topLeftCorner<3, 3>() * up));
}

double ObjectMotion::rise_sigma(const Vec3& p_W, const Vec3& up) const {
  Eigen::Matrix<double, 6, 1> per_twist;
  per_twist << up, (X_WTnow_WTref * p_W - center_W).cross(up);
  return std::sqrt(std::max(0.0, per_twist.dot(covariance * per_twist)));
}

double ObjectMotion::tilt_sigma(const Vec3& up) const {
  const auto [a, b] = hal::tangents(up);
  const Eigen::Matrix3d c = covariance.bottomRightCorner<3, 3>();
  const double aa = a.dot(c * a), bb = b.dot(c * b), ab = a.dot(c * b);
  return std::sqrt(0.5 * (aa + bb) + std::hypot(0.5 * (aa - bb), ab));
}

struct ObjectFollower::Impl {
  SurfaceSamples samples;
  hal::CameraIntrinsics k;
  Pose X_WC = Pose::Identity();
  MotionConfig config;
  std::vector<float> ray_x, ray_y;
  Information uncertain_normals = Information::Zero();  // what wrong normals alone would seem to tell
  Motion last;
  int missed = 0;

  // One pass over the samples at a motion. Turns are scaled by kTurn_m, so that all six numbers are metres.
  Sums pass(const float* depth_m, const Motion& motion, double gate_m) const {
    const Eigen::Matrix3f R = motion.turn.cast<float>();
    const Vec3 now = samples.middle + motion.shift;
    const Eigen::Vector3f middle = samples.middle.cast<float>(), centre = now.cast<float>();
    const auto fx = static_cast<float>(k.fx), fy = static_cast<float>(k.fy);
    const auto cx = static_cast<float>(k.cx) + 0.5f, cy = static_cast<float>(k.cy) + 0.5f;
    const auto gate2 = static_cast<float>(gate_m * gate_m);
    constexpr auto kPerTurn = static_cast<float>(1.0 / kTurn_m);
    const auto sigmas2 = static_cast<float>(config.gate_sigmas * config.gate_sigmas);
    float h[21] = {}, g[6] = {}, weights = 0.0f, squares = 0.0f;
    Sums sums;
    for (std::size_t i = 0; i < samples.size(); ++i) {
      const Eigen::Vector3f a = R * (Eigen::Vector3f(samples.x[i], samples.y[i], samples.z[i]) - middle);
      const Eigen::Vector3f n = R * Eigen::Vector3f(samples.nx[i], samples.ny[i], samples.nz[i]);
      const Eigen::Vector3f p = a + centre;
      if (!(p.z() > 0.1f)) {
        ++sums.outside;
        continue;
      }
      const float per_z = 1.0f / p.z();
      const float u = fx * p.x() * per_z + cx, v = fy * p.y() * per_z + cy;
      if (!(u >= 0 && v >= 0 && u < static_cast<float>(k.width) && v < static_cast<float>(k.height))) {
        ++sums.outside;
        continue;
      }
      const auto column = static_cast<std::size_t>(u), row = static_cast<std::size_t>(v);
      const float d = depth_m[row * static_cast<std::size_t>(k.width) + column];
      if (!(d > 0)) {
        ++sums.unseen;
        continue;
      }
      const Eigen::Vector3f e = Eigen::Vector3f(ray_x[column] * d, ray_y[row] * d, d) - p;
      const float r = n.dot(e), sigma2 = samples.sigma_m[i] * samples.sigma_m[i];
      const float limit2 = sigmas2 * sigma2 + gate2;
      if (!(r * r < limit2)) {
        r < 0 ? ++sums.nearer : ++sums.farther;
        continue;
      }
      ++sums.found;
      const float fall = 1.0f - r * r / limit2;
      const float weight = fall * fall / sigma2;
      const Eigen::Vector3f t = kPerTurn * a.cross(n);
      const float j[6] = {n.x(), n.y(), n.z(), t.x(), t.y(), t.z()};
      int at = 0;
      for (int row_j = 0; row_j < 6; ++row_j) {
        const float wj = weight * j[row_j];
        g[row_j] += wj * r;
        for (int c = row_j; c < 6; ++c) h[at++] += wj * j[c];
      }
      weights += weight;
      squares += weight * r * r;
    }
    int at = 0;
    for (int r = 0; r < 6; ++r) {
      sums.right[r] = static_cast<double>(g[r]);
      for (int c = r; c < 6; ++c)
        sums.information(r, c) = sums.information(c, r) = static_cast<double>(h[at++]);
    }
    sums.weight = static_cast<double>(weights);
    sums.squares = static_cast<double>(squares);
    return sums;
  }

  // A normal that is wrong by a little seems to hold the object against sliding along its surface. What such
  // errors add to the information is known and is taken out of the covariance.
  void find_uncertain_normals() {
    for (std::size_t i = 0; i < samples.size(); ++i) {
      const Vec3 n(samples.nx[i], samples.ny[i], samples.nz[i]);
      const Vec3 a = Vec3(samples.x[i], samples.y[i], samples.z[i]) - samples.middle;
      Eigen::Matrix<double, 6, 3> lever;
      lever << Eigen::Matrix3d::Identity(), cross_matrix(a) / kTurn_m;
      const double s = static_cast<double>(samples.tilt_rad[i] / samples.sigma_m[i]);
      uncertain_normals +=
          s * s * lever * (Eigen::Matrix3d::Identity() - n * n.transpose()) * lever.transpose();
    }
  }

  // Information that pulls towards the last motion. Weak everywhere; but a direction that mostly wrong
  // normals seem to hold must not wander with them, and is tied to where it was.
  [[nodiscard]] Information hold(const Sums& sums, double per_variance) const {
    const double part = static_cast<double>(sums.found) / static_cast<double>(samples.size());
    const hal::SymmetricEigen6 eigen = hal::symmetric_eigen(sums.information - part * uncertain_normals);
    const Information& basis = eigen.vectors;
    Twist pull;
    for (int i = 0; i < 6; ++i) {
      const double seeming = basis.col(i).dot(sums.information * basis.col(i));
      const double sure = std::max({eigen.values[i], 0.01 * seeming, 1e-9});
      const double doubt = std::max(0.0, seeming / sure - 1.0);
      pull[i] = per_variance + seeming * doubt * doubt;
    }
    return basis * pull.asDiagonal() * basis.transpose();
  }

  // Moves `motion` to where the samples fit; returns the last sums.
  Sums align(const float* depth_m, double reach_m, Motion& motion) const {
    // a motion of this size between two frames is as likely as none: holds what the view does not
    const double held_m = reach_m / 3.0;
    const double per_variance = 1.0 / (held_m * held_m);
    double gate_m = reach_m;
    for (int i = 0; i < config.iterations; ++i) {
      const Sums sums = pass(depth_m, motion, gate_m);
      Twist moved;
      moved << motion.shift - last.shift, kTurn_m * rotation_vector(motion.turn * last.turn.transpose());
      const Information prior = hold(sums, per_variance);
      const Twist step =
          hal::solve_symmetric<double, 6>(sums.information + prior, sums.right - prior * moved);
      motion.shift += step.head<3>();
      const Vec3 turn = step.tail<3>() / kTurn_m;
      if (turn.norm() > 1e-12)
        motion.turn = Eigen::AngleAxisd(turn.norm(), turn.normalized()).toRotationMatrix() * motion.turn;
      const bool closed = gate_m < 0.002;
      if (closed && step.norm() < kSettled_m) break;
      gate_m *= config.gate_ratio;
    }
    return pass(depth_m, motion, 0.0);
  }

  [[nodiscard]] Information covariance(const Sums& sums) const {
    const double part = static_cast<double>(sums.found) / static_cast<double>(samples.size());
    const Information sure = sums.information - part * uncertain_normals;
    const hal::SymmetricEigen6 eigen = hal::symmetric_eigen(sure);
    constexpr double kMin = 1.0 / (ObjectMotion::kUnknown * ObjectMotion::kUnknown);
    const double misfit = sums.squares / static_cast<double>(std::max<std::size_t>(1, sums.found));
    const double spread = config.shared_noise_factor * std::max(1.0, misfit);
    Twist variance;
    for (int i = 0; i < 6; ++i) variance[i] = std::min(spread / std::max(eigen.values[i], kMin), 1.0 / kMin);
    Information to_W = Information::Zero();
    to_W.topLeftCorner<3, 3>() = X_WC.linear();
    to_W.bottomRightCorner<3, 3>() = X_WC.linear() / kTurn_m;
    const Information basis = to_W * eigen.vectors;
    return basis * variance.asDiagonal() * basis.transpose();
  }

  [[nodiscard]] std::string too_little(const Sums& sums) const {
    const auto percent = [&](std::size_t n) {
      return 100.0 * static_cast<double>(n) / static_cast<double>(samples.size());
    };
    return fmt::format(
        "only {:.0f} % of the object's {} points were found again, {:.0f} % are needed: {:.0f} % are hidden "
        "behind something nearer, {:.0f} % have no depth, {:.0f} % are farther than expected, {:.0f} % are "
        "out of view",
        percent(sums.found), samples.size(), 100.0 * config.min_fraction, percent(sums.nearer),
        percent(sums.unseen), percent(sums.farther), percent(sums.outside));
  }

  std::optional<ObjectMotion> update(const hal::CameraIntrinsics& now, const std::vector<float>& depth_m,
                                     std::string* reason, const std::optional<HeldPoint>& held) {
    const auto refuse = [&](auto&& describe) -> std::optional<ObjectMotion> {
      missed = std::min(missed + 1, config.max_search_steps);
      if (reason) *reason = describe();
      return std::nullopt;
    };
    if (now.width != k.width || now.height != k.height || depth_m.size() != ray_x.size() * ray_y.size())
      return refuse([&] {
        return fmt::format("the frame has {} x {} pixels, the reference {} x {}", now.width, now.height,
                           k.width, k.height);
      });

    const double reach_m = config.max_step_m * std::min(1 + missed, config.max_search_steps);
    Motion motion = last;
    Sums sums = align(depth_m.data(), reach_m, motion);
    // what holds the object there may be an arm beside it: nearer to the hand it may fit as well
    if (held && away_from(*held, motion) > config.held_step_m) {
      Motion near = last;
      const Sums found = align(depth_m.data(), config.held_step_m, near);
      if (static_cast<double>(found.found) > config.held_fraction * static_cast<double>(sums.found)) {
        motion = near;
        sums = found;
      }
    }
    if (static_cast<double>(sums.found) < config.min_fraction * static_cast<double>(samples.size()))
      return refuse([&] { return too_little(sums); });
    const double stepped = (motion.shift - last.shift).norm();
    const double turned = rotation_vector(motion.turn * last.turn.transpose()).norm();
    if (!(stepped <= reach_m) || !(turned * samples.radius_m <= reach_m))
      return refuse([&] {
        return fmt::format("a step of {:.0f} mm and {:.1f} deg since the last frame is no small motion",
                           1e3 * stepped, hal::rad_to_deg(turned));
      });
    if (motion.shift.norm() > config.max_shift_m || rotation_vector(motion.turn).norm() > config.max_turn_rad)
      return refuse([&] {
        return fmt::format("the object would be {:.2f} m and {:.0f} deg from where it stood",
                           motion.shift.norm(), hal::rad_to_deg(rotation_vector(motion.turn).norm()));
      });

    last = motion;
    missed = 0;
    if (reason) reason->clear();
    ObjectMotion result;
    result.X_WTnow_WTref = in_W(motion);
    result.center_W = X_WC * Vec3(samples.middle + motion.shift);
    result.seen = static_cast<double>(sums.found) / static_cast<double>(samples.size());
    result.rms_m = std::sqrt(sums.squares / std::max(sums.weight, 1e-9));
    result.covariance = covariance(sums);
    return result;
  }

  [[nodiscard]] Pose in_W(const Motion& motion) const {
    Pose X_C = Pose::Identity();
    X_C.linear() = motion.turn;
    X_C.translation() = samples.middle + motion.shift - motion.turn * samples.middle;
    return X_WC * X_C * X_WC.inverse();
  }

  [[nodiscard]] double away_from(const HeldPoint& held, const Motion& motion) const {
    return (in_W(motion) * held.ref_W - held.now_W).norm();
  }

  // Turns are left as they are seen: about its own axis a pipe would follow every error of the held point.
  // The gain is not the best one then, so the covariance follows from it in Joseph's form, which stays
  // positive.
  void join(const HeldPoint& held, ObjectMotion& motion) {
    const Eigen::Matrix3d P = motion.covariance.topLeftCorner<3, 3>();
    const Eigen::Matrix3d R = config.held_sigma_m * config.held_sigma_m * Eigen::Matrix3d::Identity();
    const Eigen::Matrix3d gain = hal::solve_small_symmetric(Eigen::Matrix3d(P + R), P).transpose();
    const Vec3 held_W = motion.X_WTnow_WTref * held.ref_W;
    const Vec3 shift = gain * (held.now_W - held_W);
    Information rest = Information::Identity();
    rest.topLeftCorner<3, 3>() -= gain;
    rest.topRightCorner<3, 3>() = gain * cross_matrix(Vec3(held_W - motion.center_W));
    motion.covariance = (rest * motion.covariance * rest.transpose()).eval();
    motion.covariance.topLeftCorner<3, 3>() += gain * R * gain.transpose();
    motion.X_WTnow_WTref.translation() += shift;
    motion.center_W += shift;
    last.shift += X_WC.linear().transpose() * shift;
  }
};

ObjectFollower::~ObjectFollower() = default;
ObjectFollower::ObjectFollower(ObjectFollower&&) noexcept = default;
ObjectFollower& ObjectFollower::operator=(ObjectFollower&&) noexcept = default;

hal::Result<ObjectFollower> ObjectFollower::make(const ReferenceImage& reference, const Target& target,
                                                 const NoiseModel& noise, const MotionConfig& config) {
  if (target.pixels.empty())
    return failure(ErrorCode::BadInput, "object motion", "the target has no pixels, so nothing to follow");
  if (target.pixels.back() >= reference.cloud.size())
    return failure(ErrorCode::BadInput, "object motion",
                   fmt::format("the target has pixel {}, the reference image only {} pixels",
                               target.pixels.back(), reference.cloud.size()));
  ObjectFollower follower;
  follower.impl_ = std::make_unique<Impl>();
  Impl& impl = *follower.impl_;
  impl.samples = sample_surface(reference, target, noise, config.samples, config.sampling);
  if (impl.samples.size() < static_cast<std::size_t>(config.min_samples))
    return failure(ErrorCode::NotFound, "object motion",
                   fmt::format("only {} of the target's {} pixels lie on a surface smooth enough to be "
                               "followed, {} are needed",
                               impl.samples.size(), target.pixels.size(), config.min_samples));
  impl.k = reference.cloud.intrinsics;
  impl.X_WC = reference.cloud.X_WC;
  impl.config = config;
  for (int u = 0; u < impl.k.width; ++u)
    impl.ray_x.push_back(static_cast<float>((u - impl.k.cx) / impl.k.fx));
  for (int v = 0; v < impl.k.height; ++v)
    impl.ray_y.push_back(static_cast<float>((v - impl.k.cy) / impl.k.fy));
  impl.find_uncertain_normals();
  follower.start_again();
  return follower;
}

void ObjectFollower::start_again() {
  impl_->last = {};
  impl_->missed = 0;
  last_ = {};
  last_.center_W = impl_->X_WC * impl_->samples.middle;
}

std::optional<ObjectMotion> ObjectFollower::update(const OrganisedCloud& current, std::string* reason) {
  auto motion = impl_->update(current.intrinsics, current.depth_m, reason, std::nullopt);
  if (motion) last_ = *motion;
  return motion;
}

std::optional<ObjectMotion> ObjectFollower::update(const hal::DepthFrame& current, std::string* reason,
                                                   const std::optional<HeldPoint>& held) {
  auto motion = impl_->update(current.intrinsics, current.depth_m, reason, held);
  if (motion && held) impl_->join(*held, *motion);
  if (motion) last_ = *motion;
  return motion;
}

std::size_t ObjectFollower::samples() const {
  return impl_->samples.size();
}

}  // namespace colift::perception
