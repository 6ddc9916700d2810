#pragma once

#include <cstdint>
#include <vector>

#include "perception/calibration/calibrate.hpp"
#include "perception/calibration/next_pose.hpp"

namespace colift::tests {

/// How a simulated calibration is made; the noise is that of docs/calibration.md.
struct TrialSetting {
  int poses = 20;
  double pixel_px = 0.3;
  double arm_m = 0.001;
  bool depth = false;
  double outliers = 0.0;     ///< Part of the spots that are anywhere in the image.
  bool chosen = true;        ///< Poses as CoLift proposes them; else at random.
  double rotation_deg = 35;  ///< Of random poses: largest turn of the palm from the line of sight.
};

/// What is true, what was measured, and what came out.
struct Trial {
  hal::Pose X_BC = hal::Pose::Identity();
  hal::Vec3 emitter_H = hal::Vec3::Zero();
  hal::CameraIntrinsics camera;
  std::vector<perception::EmitterSample> samples;

  /// Root mean square over the workspace of how far a point that the camera measures perfectly is placed
  /// from where it is (m).
  [[nodiscard]] double error_m(const hal::Pose& X_BC_found,
                               const perception::CalibrationConfig& config) const;
};

[[nodiscard]] hal::CameraIntrinsics infrared_intrinsics();
/// Camera, emitter and samples drawn from a seed.
[[nodiscard]] Trial make_trial(const TrialSetting& setting, std::uint64_t seed);

}  // namespace colift::tests
