#include "tests/support/calibration_trial.hpp"

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

#include "sim_hal/synthetic/hash_random.hpp"
#include "sim_hal/synthetic/ray_caster.hpp"

namespace colift::tests {
namespace {

using hal::Pose;
using hal::Vec3;

constexpr double kRad = std::numbers::pi / 180.0;

/// A normal number, by Box and Muller.
double normal(sim_hal::Draws& draws) {
  const double u = 1.0 - draws.between(0, 1), v = draws.between(0, 1);
  return std::sqrt(-2.0 * std::log(u)) * std::cos(2.0 * std::numbers::pi * v);
}
Vec3 normal3(sim_hal::Draws& draws) {
  const double x = normal(draws), y = normal(draws);
  return {x, y, normal(draws)};
}

/// Palms anywhere in the workspace, towards the camera but for a turn about a random axis.
std::vector<Pose> random_palms(const Pose& X_BC, const TrialSetting& setting,
                               const perception::CalibrationConfig& config, sim_hal::Draws& draws) {
  std::vector<Pose> out;
  const Vec3 forward = X_BC.linear().col(2);
  const auto [u, v] = hal::tangents(-forward);
  Eigen::Matrix3d facing;
  facing.col(0) = u;
  facing.col(1) = v;
  facing.col(2) = -forward;
  for (int i = 0; i < setting.poses; ++i) {
    Pose X = Pose::Identity();
    const Vec3 axis = normal3(draws).normalized();
    X.linear() = Eigen::AngleAxisd(draws.between(-1, 1) * setting.rotation_deg * kRad, axis) * facing;
    X.translation() = config.workspace_center_m;
    for (int a = 0; a < 3; ++a) X.translation()[a] += draws.between(-0.5, 0.5) * config.workspace_size_m[a];
    out.push_back(X);
  }
  return out;
}

}  // namespace

hal::CameraIntrinsics infrared_intrinsics() {
  return {640, 488, 575.8, 575.8, 325.0, 244.0};
}

double Trial::error_m(const Pose& X_BC_found, const perception::CalibrationConfig& config) const {
  const Pose shift = X_BC_found * X_BC.inverse();
  double sum = 0.0;
  const auto grid = perception::workspace_grid(config);
  for (const Vec3& p : grid) sum += (shift * p - p).squaredNorm();
  return std::sqrt(sum / static_cast<double>(grid.size()));
}

Trial make_trial(const TrialSetting& setting, std::uint64_t seed) {
  sim_hal::Draws draws(seed, 601);
  const perception::CalibrationConfig config;
  Trial out;
  out.camera = infrared_intrinsics();
  const double away = draws.between(1.4, 1.8), side = draws.between(-50, 50) * kRad,
               up = draws.between(20, 40) * kRad;
  const Vec3 eye = config.workspace_center_m +
                   away * Vec3(std::cos(up) * std::cos(side), std::cos(up) * std::sin(side), std::sin(up));
  const Vec3 off(draws.between(-0.1, 0.1), draws.between(-0.1, 0.1), draws.between(-0.1, 0.1));
  out.X_BC = sim_hal::look_at(eye, config.workspace_center_m + off);
  out.emitter_H = Vec3(0.020, -0.015, 0.012) + 0.01 * normal3(draws);

  std::vector<Pose> palms;
  if (setting.chosen) {
    // the operator knows the camera's place to a few decimetres
    const auto rough = perception::rough_camera(eye + 0.15 * normal3(draws), config.workspace_center_m,
                                                out.camera, Vec3::Zero());
    perception::PoseConfig poses;
    poses.candidates = 200;
    const auto candidates = perception::candidate_poses(hal::built_in_robot(), rough, config, poses, seed);
    for (const auto& c :
         perception::choose_poses(candidates, {}, rough, config, static_cast<std::size_t>(setting.poses)))
      palms.push_back(c.X_BH);
  } else {
    palms = random_palms(out.X_BC, setting, config, draws);
  }

  perception::EmitterModel truth;
  truth.set_X_BC(out.X_BC);
  truth.p_H = out.emitter_H;
  for (const Pose& X_BH : palms) {
    perception::EmitterSample s;
    s.X_BH = X_BH;
    Pose where = X_BH;  // the arm is not quite where its joints say
    where.translation() += setting.arm_m * normal3(draws);
    const Vec3 y = truth.in_camera(where);
    const Eigen::Vector2d noise(normal(draws), normal(draws));
    s.pixel = Eigen::Vector2d(out.camera.fx * y.x() / y.z() + out.camera.cx,
                              out.camera.fy * y.y() / y.z() + out.camera.cy) +
              setting.pixel_px * noise;
    if (setting.depth) s.depth_m = y.z() + 0.004 + perception::depth_sigma(y.z()) * normal(draws);
    if (draws.chance(setting.outliers))
      s.pixel = Eigen::Vector2d(draws.between(0, out.camera.width), draws.between(0, out.camera.height));
    out.samples.push_back(s);
  }
  return out;
}

}  // namespace colift::tests
