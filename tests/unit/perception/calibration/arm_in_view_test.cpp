// Figures of single trials: unit_perception "[arm_in_view]" -s
#include <fmt/format.h>
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <vector>

#include "../figures.hpp"
#include "hal/types/units.hpp"
#include "perception/calibration/arm_in_view/camera_correction.hpp"
#include "perception/calibration/pose_check.hpp"
#include "perception/reference_image.hpp"
#include "sim_hal/imperfect/rig_errors.hpp"
#include "sim_hal/synthetic/kinect/kinect_noise.hpp"
#include "tests/unit/perception/self_filter/robot_view.hpp"

using namespace colift;
using hal::Vec3;
using perception::CameraCorrection;
using perception::quantile;
using sim_hal::Draws;
using sim_hal::Label;

namespace {

constexpr int kFrames = 15;
const hal::Aabb kWorkspace(Vec3(0.4, -0.4, 0.1), Vec3(1.0, 0.4, 0.7));

/// The robot at home, a box before it, a bin and a wall somewhere: 15 frames, and what is wrong with them.
struct ArmView {
  hal::RobotModel model = hal::built_in_robot();
  hal::JointVector q_rad = (hal::JointVector() << 0.0, 0.35, 0.0, 1.75, 0.0, -0.9, 0.0).finished();
  hal::HandPosture hand;
  hal::Pose X_WC, X_WK;  // true, calibrated
  hal::DepthFrame mean;

  ArmView(std::uint64_t seed, const sim_hal::CameraErrors& errors, double floor_m = 0.0) {
    Draws draws(seed, 77);
    for (int i = 0; i < hal::kArmJoints; ++i) q_rad[i] += draws.between(-0.15, 0.15);
    sim_hal::World world;
    world.shapes.push_back(sim_hal::half_space(Vec3(0, 0, floor_m), Vec3::UnitZ(), Label::Ground));
    world.shapes.push_back(sim_hal::box(Vec3(1.15, draws.between(-0.2, 0.2), floor_m + 0.22),
                                        {0.8, 0.6, 0.44}, draws.between(-0.5, 0.5), Label::Target));
    world.shapes.push_back(sim_hal::cylinder(Vec3(draws.between(0.2, 0.6), 0.8, floor_m + 0.2), Vec3::UnitZ(),
                                             0.14, 0.4, Label::Clutter));
    if (draws.chance(0.5))
      world.shapes.push_back(
          sim_hal::half_space(Vec3(0, draws.between(1.2, 2.0), 0), -Vec3::UnitY(), Label::Wall));
    perception::test::add_robot(world, model, q_rad, hand);
    X_WC = sim_hal::look_at(Vec3(draws.between(1.7, 2.3), draws.between(-1.6, -0.7), draws.between(1.2, 1.7)),
                            Vec3(draws.between(0.7, 1.2), 0.0, 0.3));
    X_WK = X_WC * errors.X_CK;
    const hal::CameraIntrinsics ideal;
    const auto truth = sim_hal::cast_rays(world, ideal, X_WC);
    std::vector<hal::DepthFrame> frames;
    for (int i = 0; i < kFrames; ++i) {
      hal::DepthFrame frame = sim_hal::measure(truth, {}, 100 * seed + static_cast<std::uint64_t>(i));
      spoil(frame, errors);
      frames.push_back(std::move(frame));
    }
    mean = frames.back();
    mean.depth_m = perception::build_reference(frames, X_WK, {})->cloud.depth_m;
  }

  static void spoil(hal::DepthFrame& frame, const sim_hal::CameraErrors& errors) {
    const auto k = frame.intrinsics;
    const auto from = frame.depth_m;
    for (int v = 0; v < k.height; ++v)
      for (int u = 0; u < k.width; ++u) {
        const double x = (u - k.cx) / k.fx, y = (v - k.cy) / k.fy;
        const double s = 1.0 - errors.distortion * (x * x + y * y);
        const auto a = std::lround(k.cx + k.fx * x * s), b = std::lround(k.cy + k.fy * y * s);
        const bool inside = a >= 0 && b >= 0 && a < k.width && b < k.height;
        frame.depth_m[static_cast<std::size_t>(v * k.width + u)] =
            inside ? from[static_cast<std::size_t>(b * k.width + a)] *
                         static_cast<float>(1.0 + errors.depth_scale)
                   : NAN;
      }
    frame.intrinsics.fx *= 1.0 + errors.focal_length;
    frame.intrinsics.fy *= 1.0 + errors.focal_length;
  }

  [[nodiscard]] CameraCorrection estimate(const perception::CorrectionConfig& config = {}) const {
    return perception::estimate_correction(mean, kFrames, X_WK, model, q_rad, hand, {}, kWorkspace, config);
  }

  /// Root mean square error of points of the workspace as they are placed, with a correction.
  [[nodiscard]] double error_m(const sim_hal::CameraErrors& errors, const CameraCorrection& c) const {
    double sum = 0.0;
    int n = 0;
    for (const double x : {0.4, 0.7, 1.0})
      for (const double y : {-0.4, 0.0, 0.4})
        for (const double z : {0.1, 0.4, 0.7}) {
          const Vec3 p(x, y, z);
          // where the lens images it, and what the camera makes of that
          const Vec3 p_C = X_WC.inverse() * p;
          const double a = p_C.x() / p_C.z(), b = p_C.y() / p_C.z();
          const double s = 1.0 + errors.distortion * (a * a + b * b);
          const double focal = (1.0 + errors.focal_length) * (c.applied() ? c.focal_scale : 1.0);
          const double depth = p_C.z() * (1.0 + errors.depth_scale) * (c.applied() ? c.depth_scale : 1.0);
          const Vec3 seen_C = depth * Vec3(a * s / focal, b * s / focal, 1.0);
          const hal::Pose X = c.applied() ? X_WK * c.X_KC : X_WK;
          sum += (X * seen_C - p).squaredNorm();
          ++n;
        }
    return std::sqrt(sum / n);
  }
};

sim_hal::CameraErrors drawn(std::uint64_t seed) {
  const auto figures = sim_hal::load_rig_figures("imperfect");
  REQUIRE(figures);
  return sim_hal::draw_rig_errors(*figures, seed).camera;
}

}  // namespace

TEST_CASE("a camera with the errors of a lab is corrected from the arm in its image", "[arm_in_view]") {
  std::vector<double> before, after, sigmas;
  int applied = 0, checked = 0;
  constexpr int kTrials = 24;
  for (std::uint64_t seed = 1; seed <= kTrials; ++seed) {
    const auto errors = drawn(seed);
    const ArmView view(seed, errors);
    CameraCorrection c = view.estimate();
    before.push_back(1e3 * view.error_m(errors, {}));
    after.push_back(1e3 * view.error_m(errors, c));
    sigmas.push_back(1e3 * c.sigma_m);
    applied += c.applied();
    hal::DepthFrame corrected = view.mean;
    c.correct(corrected);
    const auto check = perception::check_pose(corrected, c.applied() ? view.X_WK * c.X_KC : view.X_WK,
                                              std::nullopt, view.model, view.q_rad, view.hand, {});
    checked += check.good;
    UNSCOPED_INFO(fmt::format(
        "{:2}: {:4.1f} -> {:4.1f} mm (sigma {:.1f}); scale {:+.2f} % f {:+.2f} % k {:+.2f}; "
        "{} ({} arm, {} floor); {}",
        seed, before.back(), after.back(), sigmas.back(), 1e2 * errors.depth_scale, 1e2 * errors.focal_length,
        errors.distortion, c.reason, c.arm_points, c.floor_points, check.reason));
  }
  UNSCOPED_INFO(fmt::format(
      "before median {:.1f}, after median {:.1f}, 90 % {:.1f}, worst {:.1f} mm; applied {}",
      quantile(before, 0.5), quantile(after, 0.5), quantile(after, 0.9), quantile(after, 1.0), applied));
  CHECK(checked == kTrials);
  CHECK(applied >= kTrials - 1);
  CHECK(quantile(after, 0.5) < 3.0);
  CHECK(quantile(after, 0.9) < 4.0);
}

TEST_CASE("an exact camera keeps its calibration, and the estimate is within its sigma", "[arm_in_view]") {
  std::vector<double> shifts;
  int applied = 0, within = 0;
  constexpr int kTrials = 16;
  for (std::uint64_t seed = 101; seed < 101 + kTrials; ++seed) {
    const ArmView view(seed, {});
    const CameraCorrection c = view.estimate();
    applied += c.verdict != CameraCorrection::Verdict::Kept;
    within += c.shift_m < c.sigma_m;
    shifts.push_back(1e3 * c.shift_m);
    UNSCOPED_INFO(fmt::format("{}: {:.1f} mm (sigma {:.1f}): {}; t {:.1f} {:.1f} {:.1f} mm", seed,
                              shifts.back(), 1e3 * c.sigma_m, c.reason, 1e3 * c.X_KC.translation().x(),
                              1e3 * c.X_KC.translation().y(), 1e3 * c.X_KC.translation().z()));
  }
  CHECK(applied == 0);
  CHECK(within == kTrials);
  CHECK(quantile(shifts, 1.0) < 2.0);
}

TEST_CASE("a camera that was pushed by more than a calibration is off is not corrected", "[arm_in_view]") {
  sim_hal::CameraErrors errors;
  errors.X_CK.translate(Vec3(0.08, 0.0, 0.0));
  for (std::uint64_t seed = 201; seed < 205; ++seed) {
    const CameraCorrection c = ArmView(seed, errors).estimate();
    INFO(c.reason);
    CHECK(c.verdict == CameraCorrection::Verdict::Refused);
    CHECK(c.reason.find("at most 30 mm, 1.5 deg") != std::string::npos);
  }
}

TEST_CASE("a floor that is not at the base's height leaves the camera alone", "[arm_in_view]") {
  for (std::uint64_t seed = 301; seed < 305; ++seed) {
    const CameraCorrection c = ArmView(seed, {}, 0.03).estimate();
    INFO(c.reason);
    CHECK(c.verdict == CameraCorrection::Verdict::Kept);
    CHECK(c.shift_m < 0.008);
  }
}

TEST_CASE("without the arm in view nothing is corrected", "[arm_in_view]") {
  ArmView view(1, drawn(1));
  for (float& z : view.mean.depth_m) z = NAN;
  const CameraCorrection c = view.estimate();
  CHECK(c.verdict == CameraCorrection::Verdict::Kept);
  CHECK(c.reason.find("0 pixels of the arm") != std::string::npos);
  hal::DepthFrame frame = view.mean;
  c.correct(frame);
  CHECK(frame.intrinsics.fx == view.mean.intrinsics.fx);
}
