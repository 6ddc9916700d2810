#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "hal/config/range.hpp"
#include "hal/types/result.hpp"
#include "perception/calibration/emitter_model.hpp"

namespace colift::perception {

/// How a calibration is solved and when it is refused. Numbers: simulation, see docs/calibration.md.
struct CalibrationConfig {
  double pixel_px = 0.3;
  double arm_m = 0.001;
  Vec3 emitter_m = Vec3::Zero();
  double emitter_sigma_m = 0.10;
  bool use_depth = true;
  bool intrinsics = false;
  double inlier_px = 2.0;
  int draws = 400;
  int min_inliers = 12;
  double min_inlier_fraction = 0.6;
  double max_rms_px = 1.0;
  double max_emitter_sigma_m = 0.005;
  double max_error_m = 0.005;
  double max_condition = 1e5;
  double min_rotation_deg = 6.0;
  double min_thickness_m = 0.015;
  double shift_m = 0.002;
  int min_draws = 40;
  double inlier_sigmas = 3.5;
  double depth_gate_m = 0.03;
  double max_camera_distance_m = 5.0;
  double max_emitter_distance_m = 0.5;
  Vec3 workspace_center_m{0.65, 0.0, 0.45};
  Vec3 workspace_size_m{0.45, 0.9, 0.7};

  template <class Visitor>
  void visit(Visitor& v) {
    v("pixel_px", pixel_px, hal::Range{0.01, 10}, "Min standard deviation of a found spot, per axis (px).");
    v("arm_m", arm_m, hal::Range{1e-6, 0.02}, "Absolute error of the arm's position, per axis (m).");
    v("emitter_m", emitter_m, hal::Range{-0.5, 0.5},
      "Approximate position of the emitter in the palm frame (m).");
    v("emitter_sigma_m", emitter_sigma_m, hal::Range{0.001, 0.5}, "Standard deviation of that position (m).");
    v("use_depth", use_depth, "Whether depths near the emitter count.");
    v("intrinsics", intrinsics, "Estimates the camera's intrinsics too; needs depths.");
    v("inlier_px", inlier_px, hal::Range{0.1, 50},
      "Max distance of an inlier from its predicted pixel (px).");
    v("draws", draws, hal::Range{20, 5000}, "Max number of random draws of seven poses.");
    v("min_inliers", min_inliers, hal::Range{8, 1000}, "Min number of inlier poses.");
    v.renamed("least_inliers", "min_inliers");
    v("min_inlier_fraction", min_inlier_fraction, hal::kFraction, "Min fraction of inlier poses.");
    v.renamed("least_inlier_share", "min_inlier_fraction");
    v("max_rms_px", max_rms_px, hal::kPositive, "Max root mean square residual (px).");
    v("max_emitter_sigma_m", max_emitter_sigma_m, hal::kPositive,
      "Max standard deviation of the emitter's position (m).");
    v("max_error_m", max_error_m, hal::kPositive,
      "Max predicted error of a point in the workspace, root mean square (m).");
    v("max_condition", max_condition, hal::kPositive, "Max condition number of the normal equations.");
    v("min_rotation_deg", min_rotation_deg, hal::Range{0, 90},
      "Min spread of the poses' rotation about a second axis (deg).");
    v.renamed("least_rotation_deg", "min_rotation_deg");
    v("min_thickness_m", min_thickness_m, hal::kNotNegative,
      "Min spread of the emitter's positions out of one plane (m).");
    v.renamed("least_thickness_m", "min_thickness_m");
    v("shift_m", shift_m, hal::kPositive,
      "Shift of points in the workspace without one pose, above which that pose is reported (m).");
    v("workspace_center_m", workspace_center_m, hal::Range{-3, 3}, "Middle of the workspace (m).");
    v("workspace_size_m", workspace_size_m, hal::Range{0.05, 3}, "Size of the workspace (m).");
    v("min_draws", min_draws, hal::Range{1, 5000},
      "Min number of random draws, also where all agree: not every start value converges.");
    v("inlier_sigmas", inlier_sigmas, hal::Range{1, 20},
      "Max distance of an inlier in standard deviations, where that is more than inlier_px.");
    v("depth_gate_m", depth_gate_m, hal::Range{0.001, 1},
      "Max difference between a depth and the emitter's (m).");
    v("max_camera_distance_m", max_camera_distance_m, hal::kPositive,
      "Max distance of a plausible camera from the base (m).");
    v("max_emitter_distance_m", max_emitter_distance_m, hal::kPositive,
      "Max distance of a plausible emitter from the palm (m).");
  }
};

/// How different the poses of a set are.
struct PoseDiversity {
  Vec3 rotation_deg = Vec3::Zero();  ///< Spread of the palm's rotation about three axes, largest first (deg).
  Vec3 position_m = Vec3::Zero();    ///< Standard deviation of the emitter along three axes, largest first.
  double score = 0.0;                ///< 0: degenerate; 1: as good as poses get.
};
[[nodiscard]] PoseDiversity diversity_of(std::span<const EmitterSample> samples, std::span<const int> use,
                                         const Vec3& p_H);

/// What became of one pose.
struct SampleVerdict {
  Eigen::Vector2d residual_px = Eigen::Vector2d::Zero();  ///< Infinite behind the camera.
  double held_out_px = 0.0;                               ///< Residual when solved without this pose.
  double shift_m = 0.0;  ///< Of placed points in the workspace, when solved without this pose.
  std::optional<double> depth_residual_m;
  bool inlier = false;
};

/// A solved calibration with all that says how good it is. It may be refused.
struct Calibration {
  EmitterModel model;
  Eigen::Matrix<double, kPoseParameters, kPoseParameters> covariance =
      Eigen::Matrix<double, kPoseParameters, kPoseParameters>::Zero();
  std::vector<SampleVerdict> samples;
  int inliers = 0;
  double rms_px = 0.0;       ///< Of the inliers.
  double held_out_px = 0.0;  ///< The same, each pose predicted by the others.
  double error_m = 0.0;      ///< Predicted: of placed points, root mean square over the workspace.
  double worst_error_m = 0.0;
  double emitter_sigma_m = 0.0;
  double condition = 0.0;
  double chi2_per_dof = 0.0;
  PoseDiversity diversity;
  std::vector<std::string> remarks;
};

/// Why there is no calibration.
struct CalibrationRefusal {
  std::string kind;  ///< One word, for programs: "few-inliers", "one-orientation", "uncertain", ...
  std::string reason;
  std::optional<Calibration> solved;  ///< As far as it came.
};

/// Points of the workspace at which errors are predicted and measured: 3 x 3 x 2.
[[nodiscard]] std::vector<Vec3> workspace_grid(const CalibrationConfig& config);

/// Predicted error of points that a perfect camera sees, root mean square over these points and at the worst
/// one (m), from the covariance of R and t.
struct PlacingError {
  double rms_m = 0.0, worst_m = 0.0;
};
[[nodiscard]] PlacingError placing_error(const EmitterModel& model,
                                         const Eigen::Matrix<double, 6, 6>& covariance,
                                         std::span<const Vec3> points_B);

/// Camera pose in the base and emitter in the palm from spots at many poses of the arm: closed-form start on
/// random sevens, MSAC, Levenberg-Marquardt (Huber, then least squares on the inliers), covariance, what each
/// pose is worth. `camera`: intrinsics of the infrared image. Same samples and seed: same bits.
[[nodiscard]] tl::expected<Calibration, CalibrationRefusal> calibrate(std::span<const EmitterSample> samples,
                                                                      const hal::CameraIntrinsics& camera,
                                                                      const CalibrationConfig& config,
                                                                      std::uint64_t seed);

}  // namespace colift::perception
