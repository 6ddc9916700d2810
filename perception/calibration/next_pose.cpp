#include "perception/calibration/next_pose.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <random>

#include "hal/types/symmetric.hpp"
#include "hal/types/units.hpp"

namespace colift::perception {
namespace {

constexpr double kWristReach_m =
    0.35;  // beside the workspace; turning the wrist moves the palm less than this

/// Numbers of [0, 1) that are the same everywhere.
class Random {
 public:
  explicit Random(std::uint64_t seed) : engine_(seed) {}
  double between(double low, double high) {
    return low + (high - low) * static_cast<double>(engine_() >> 11) * 0x1p-53;
  }

 private:
  std::mt19937_64 engine_;
};

using Information = Eigen::Matrix<double, kPoseParameters, kPoseParameters>;

/// What one more pose tells about camera and emitter.
Information information_of(const Pose& X_BH, const EmitterModel& model, const EmitterNoise& noise) {
  EmitterSample sample;
  sample.X_BH = X_BH;
  EmitterRows rows;
  rows.samples = {0};
  return linearise({&sample, 1}, model, model, rows, noise).H;
}

double predicted_error(const Information& H, const EmitterModel& model, std::span<const Vec3> grid) {
  const Information S = hal::solve_small_symmetric(H, Information::Identity());
  return placing_error(model, S.topLeftCorner<6, 6>(), grid).rms_m;
}

}  // namespace

EmitterModel rough_camera(const Vec3& eye_B, const Vec3& at_B, const hal::CameraIntrinsics& camera,
                          const Vec3& emitter_H) {
  EmitterModel model;
  model.camera = camera;
  model.p_H = emitter_H;
  Pose X = Pose::Identity();
  const Vec3 forward = (at_B - eye_B).normalized();
  const Vec3 helper = std::abs(forward.z()) < 0.99 ? Vec3::UnitZ() : Vec3::UnitX();
  const Vec3 right = forward.cross(helper).normalized();
  X.linear().col(0) = right;
  X.linear().col(1) = forward.cross(right);
  X.linear().col(2) = forward;
  X.translation() = eye_B;
  model.set_X_BC(X);
  return model;
}

std::vector<ProposedPose> candidate_poses(const hal::RobotModel& robot, const EmitterModel& camera,
                                          const CalibrationConfig& calibration, const PoseConfig& config,
                                          std::uint64_t seed) {
  Random random(seed);
  const hal::JointVector margin = hal::JointVector::Constant(hal::deg_to_rad(config.margin_deg));
  const hal::JointVector lower = robot.lower_rad() + margin, upper = robot.upper_rad() - margin;
  const Vec3 low = calibration.workspace_center_m - 0.5 * calibration.workspace_size_m;
  const Vec3 high = calibration.workspace_center_m + 0.5 * calibration.workspace_size_m;
  const Pose X_BC = camera.X_BC();
  const auto& k = camera.camera;
  const double cos_view = std::cos(hal::deg_to_rad(config.view_angle_deg));
  const double cos_roll = std::cos(hal::deg_to_rad(config.roll_deg));

  std::vector<ProposedPose> out;
  std::vector<Pose> X_WL;
  const auto in_view = [&](const ProposedPose& pose) {
    const Vec3 palm = pose.X_BH.translation();
    if ((palm.array() < low.array()).any() || (palm.array() > high.array()).any()) return false;
    const Vec3 to_camera = X_BC.translation() - pose.X_BH * camera.p_H;
    if (pose.X_BH.linear().col(2).dot(to_camera.normalized()) < cos_view) return false;
    // upright: the hand's x axis is level in the image or the other way round, fingers to either side
    const Vec3 x_C = camera.R_CB * pose.X_BH.linear().col(0);
    if (std::abs(x_C.x()) < cos_roll * std::hypot(x_C.x(), x_C.y())) return false;
    const Vec3 y = camera.in_camera(pose.X_BH);
    if (y.z() < config.nearest_m || y.z() > config.farthest_m) return false;
    const double u = k.fx * y.x() / y.z() + k.cx, v = k.fy * y.y() / y.z() + k.cy;
    return u > config.border_px && v > config.border_px && u < k.width - config.border_px &&
           v < k.height - config.border_px;
  };
  const auto above_floor = [&](const ProposedPose& pose) {
    hal::link_poses(robot, pose.q_rad, {}, X_WL);
    // the links from the elbow on; the base stands on the floor
    for (std::size_t i = 3; i < robot.arm.size(); ++i)
      if (X_WL[static_cast<std::size_t>(robot.arm[i])].translation().z() < config.lowest_m) return false;
    return pose.X_BH.translation().z() > config.lowest_m;
  };
  const long draws = static_cast<long>(config.candidates) * config.max_draws_per_candidate;
  for (long draw = 0; draw < draws && out.size() < static_cast<std::size_t>(config.candidates); ++draw) {
    ProposedPose pose;
    for (int i = 0; i < hal::kArmJoints; ++i) pose.q_rad[i] = random.between(lower[i], upper[i]);
    // the wrist turns the palm without moving its place much: several directions for each place
    for (int turn = 0; turn < config.postures_per_place; ++turn) {
      pose.X_BH = hal::hand_pose(robot, pose.q_rad);
      if (in_view(pose) && above_floor(pose)) {
        out.push_back(pose);
        break;
      }
      const Vec3 wrist = pose.X_BH.translation();
      if (((wrist - calibration.workspace_center_m).cwiseAbs() - 0.5 * calibration.workspace_size_m)
              .maxCoeff() > kWristReach_m)
        break;
      for (int i = 4; i < hal::kArmJoints; ++i) pose.q_rad[i] = random.between(lower[i], upper[i]);
    }
  }
  return out;
}

std::vector<ProposedPose> choose_poses(std::span<const ProposedPose> candidates, std::span<const Pose> done,
                                       const EmitterModel& model, const CalibrationConfig& config,
                                       std::size_t count,
                                       const std::function<bool(const ProposedPose&)>& usable) {
  const EmitterNoise noise{config.pixel_px, config.arm_m};
  const std::vector<Vec3> grid = workspace_grid(config);
  // a little is known from the start, so that the first poses can be compared too
  Information H = Information::Zero();
  H.diagonal().head<3>().setConstant(1.0 / (0.3 * 0.3));
  H.diagonal().segment<3>(3).setConstant(1.0 / (0.3 * 0.3));
  H.diagonal().tail<3>().setConstant(1.0 / (config.emitter_sigma_m * config.emitter_sigma_m));
  for (const Pose& X : done) H += information_of(X, model, noise);

  std::vector<Information> gain;
  for (const ProposedPose& c : candidates) gain.push_back(information_of(c.X_BH, model, noise));
  std::vector<char> gone(candidates.size(), 0);
  std::vector<ProposedPose> out;
  while (out.size() < count) {
    std::size_t best = candidates.size();
    double best_error = 0.0;
    for (std::size_t i = 0; i < candidates.size(); ++i) {
      if (gone[i]) continue;
      const double error = predicted_error(H + gain[i], model, grid);
      if (best != candidates.size() && !(error < best_error)) continue;
      best = i;
      best_error = error;
    }
    if (best == candidates.size()) break;
    gone[best] = 1;
    if (usable && !usable(candidates[best])) continue;
    H += gain[best];
    out.push_back(candidates[best]);
    out.back().error_m = best_error;
  }
  return out;
}

}  // namespace colift::perception
