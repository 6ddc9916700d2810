#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "hal/config/range.hpp"
#include "hal/types/result.hpp"
#include "perception/calibration/calibrate.hpp"

namespace colift::perception {

/// One pose in a calibration file.
struct FiledPose {
  double u_px = 0.0, v_px = 0.0;
  bool inlier = true;
  double held_out_px = 0.0;

  template <class Visitor>
  void visit(Visitor& v) {
    v("u_px", u_px, hal::kAny, "Residual along the image's rows (px).");
    v("v_px", v_px, hal::kAny, "Residual along its columns (px).");
    v("inlier", inlier, "Whether the pose was used.");
    v("held_out_px", held_out_px, hal::kNotNegative, "Residual when solved without this pose (px).");
  }
};

/// What `colift calibrate` writes and every other command reads (schema colift.calibration/1).
struct CalibrationFile {
  std::string schema = "colift.calibration/1";
  std::string date, method;
  Vec3 camera_xyz_m = Vec3::Zero();                       ///< Camera optical frame C in the base.
  std::vector<double> camera_quaternion{0, 0, 0, 1};      ///< x, y, z, w
  Vec3 emitter_m = Vec3::Zero();                          ///< In the palm frame.
  double fx = 575.8, fy = 575.8, cx = 325.0, cy = 244.0;  ///< Of the infrared image.
  double depth_scale = 1.0, depth_offset_m = 0.0;
  double error_m = 0.0, worst_error_m = 0.0, rms_px = 0.0, held_out_px = 0.0;
  int inliers = 0;
  double diversity = 0.0;
  std::vector<double>
      covariance;  ///< 9 x 9, row by row: rotation (rad, in C), translation of B in C, emitter.
  std::vector<FiledPose> poses;

  template <class Visitor>
  void visit(Visitor& v) {
    using hal::Presence;
    v("schema", schema, hal::Choices{"colift.calibration/1"}, "What this file is.", Presence::Required);
    v("date", date, "When it was calibrated.");
    v("method", method, "How.");
    v("camera_xyz_m", camera_xyz_m, hal::Range{-10, 10}, "Camera in the robot's base (m).",
      Presence::Required);
    v("camera_quaternion", camera_quaternion, hal::Range{-1.01, 1.01},
      "Its optical frame there (x right, y down, z forward) as x, y, z, w.", Presence::Required);
    v("emitter_m", emitter_m, hal::Range{-1, 1}, "The emitter in the palm frame (m).");
    v("fx", fx, hal::kPositive, "Intrinsics of the infrared image (px).");
    v("fy", fy, hal::kPositive, "The same.");
    v("cx", cx, hal::kAny, "The same; the depth image's is 5 less.");
    v("cy", cy, hal::kAny, "The same; the depth image's is 4 less.");
    v("depth_scale", depth_scale, hal::Range{0.5, 2}, "Measured depth near the emitter / true depth.");
    v("depth_offset_m", depth_offset_m, hal::Range{-1, 1}, "And what is added to it (m).");
    v("error_m", error_m, hal::kNotNegative,
      "Predicted error of a placed point, root mean square over the workspace (m).", Presence::Required);
    v("worst_error_m", worst_error_m, hal::kNotNegative, "The same at the worst place (m).");
    v("rms_px", rms_px, hal::kNotNegative, "Residual of the poses that were used (px).", Presence::Required);
    v("held_out_px", held_out_px, hal::kNotNegative, "The same, each pose predicted by the others (px).");
    v("inliers", inliers, hal::Range{0, 100000}, "Poses that were used.", Presence::Required);
    v("diversity", diversity, hal::kFraction, "How different the poses are; 1 is as good as it gets.");
    v("covariance", covariance, hal::kAny,
      "9 x 9, row by row: rotation (rad) and translation (m) of the base in C, emitter (m).");
    v("poses", poses, "Each pose in the order of the samples.");
  }
  [[nodiscard]] Pose X_BC() const;
};

/// `date` and `method` are handed in.
[[nodiscard]] CalibrationFile file_of(const Calibration& calibration, const std::string& date,
                                      const std::string& method);
/// As YAML.
[[nodiscard]] std::string text_of(const CalibrationFile& file);

/// Errors: BadConfig with file:line:column, what was found and what was expected; also for a quaternion that
/// is none, a covariance of another size, and a calibration that would have been refused (`limits`).
[[nodiscard]] hal::Result<CalibrationFile> parse_calibration(const std::string& yaml, const std::string& name,
                                                             const CalibrationConfig& limits = {});
[[nodiscard]] hal::Result<CalibrationFile> load_calibration(const std::filesystem::path& file,
                                                            const CalibrationConfig& limits = {});

}  // namespace colift::perception
