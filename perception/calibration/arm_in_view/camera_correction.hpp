#pragma once

#include <string>

#include "hal/config/range.hpp"
#include "hal/depth_camera.hpp"
#include "hal/robot_model/robot_model.hpp"
#include "perception/noise_model.hpp"

namespace colift::perception {

/// How far a calibration may be off, and when it is corrected.
struct CorrectionConfig {
  bool on = true;
  double position_sigma_m = 0.005;
  double rotation_sigma_deg = 0.5;
  double depth_scale_sigma = 0.01;
  double focal_sigma = 0.005;
  double distortion_sigma = 0.02;
  double link_sigma_m = 0.002;
  double floor_sigma_m = 0.003;
  double floor_tilt_sigma_deg = 0.1;
  double surface_sigma_m = 0.003;
  double max_shift_m = 0.05;
  double max_position_m = 0.03;
  double max_rotation_deg = 1.5;
  double max_depth_scale = 0.025;
  double max_residual_m = 0.012;
  double min_shift_m = 0.008;
  double min_sigmas = 4.0;
  int min_points = 400;
  double reach_m = 0.08;
  double cut_m = 0.025;
  double min_arm_height_m = 0.08;
  double max_depth_step_m = 0.05;
  int edge_px = 3;
  int stride = 2;
  int floor_stride = 6;
  int correlated_px = 5;
  int iterations = 20;

  template <class Visitor>
  void visit(Visitor& v) {
    v("on", on,
      "Whether a run corrects the camera's calibration from the arm and the floor in its image, before the "
      "partner comes.");
    v("position_sigma_m", position_sigma_m, hal::Range{1e-6, 0.1},
      "Standard deviation of the calibrated position along each axis, assumed (m).");
    v("rotation_sigma_deg", rotation_sigma_deg, hal::Range{1e-4, 10},
      "Standard deviation of the calibrated orientation about each axis, assumed (deg).");
    v("depth_scale_sigma", depth_scale_sigma, hal::Range{1e-6, 0.1},
      "Standard deviation of the scale of the depths, assumed (fraction).");
    v("focal_sigma", focal_sigma, hal::Range{1e-6, 0.1},
      "Standard deviation of the focal length, assumed (fraction).");
    v("distortion_sigma", distortion_sigma, hal::Range{1e-6, 0.5},
      "Standard deviation of the radial distortion k1 that is not taken out, assumed.");
    v("link_sigma_m", link_sigma_m, hal::Range{1e-5, 0.05},
      "Standard deviation of each link's surface about its model, along each axis (m).");
    v("floor_sigma_m", floor_sigma_m, hal::Range{1e-5, 0.1},
      "Standard deviation of the floor's height about z = 0 of the base (m).");
    v("floor_tilt_sigma_deg", floor_tilt_sigma_deg, hal::Range{1e-4, 10},
      "Standard deviation of the floor's tilt against the base (deg).");
    v("surface_sigma_m", surface_sigma_m, hal::Range{1e-5, 0.05},
      "Standard deviation of a measured point about a surface, beside the depth noise (m).");
    v("max_shift_m", max_shift_m, hal::Range{0, 0.5},
      "Max shift of the workspace by the correction, root mean square (m).");
    v("max_position_m", max_position_m, hal::Range{0, 0.5}, "Max correction of the position (m).");
    v("max_rotation_deg", max_rotation_deg, hal::Range{0, 20}, "Max correction of the orientation (deg).");
    v("max_depth_scale", max_depth_scale, hal::Range{0, 0.2},
      "Max correction of the scale of the depths (fraction).");
    v("max_residual_m", max_residual_m, hal::Range{0.0001, 0.1},
      "Max distance of the arm's points from its model after the correction, root mean square (m).");
    v("min_shift_m", min_shift_m, hal::Range{0, 0.1},
      "Min shift of the workspace, root mean square: a smaller correction is not made (m).");
    v("min_sigmas", min_sigmas, hal::Range{0, 100},
      "Min shift of the workspace in its own standard deviations: a less certain correction is not made.");
    v("min_points", min_points, hal::Range{20, 100000},
      "Min number of pixels of the arm in view for a correction.");
    v("reach_m", reach_m, hal::Range{0.01, 0.3}, "Max distance of the arm's points from the model (m).");
    v("cut_m", cut_m, hal::Range{0.001, 0.3},
      "Max distance of a point from the corrected model; what is farther off is something else (m).");
    v("min_arm_height_m", min_arm_height_m, hal::Range{0, 2},
      "Min height of the arm's points: what is lower is the floor or the base's foot (m).");
    v("max_depth_step_m", max_depth_step_m, hal::Range{0.001, 1},
      "Max depth difference around a pixel that is used; at a silhouette it is larger (m).");
    v("edge_px", edge_px, hal::Range{1, 20},
      "Min distance of the arm's pixels from a silhouette, where a near surface looks too large (px).");
    v("stride", stride, hal::Range{1, 32}, "Every n-th pixel of every n-th row of the arm is used.");
    v("floor_stride", floor_stride, hal::Range{1, 64}, "The same for the floor.");
    v("correlated_px", correlated_px, hal::Range{1, 64},
      "Width of the patch of pixels that share their error (px).");
    v("iterations", iterations, hal::Range{2, 1000}, "Max number of iterations of the fit.");
  }
};

/// By how much a camera's calibration is off, from the arm and the floor in its image.
struct CameraCorrection {
  enum class Verdict {
    Kept,     ///< Not corrected: too small or too uncertain to be worth it, or nothing was observable.
    Applied,  ///< Pose, depths and focal length are corrected by the figures below.
    Refused,  ///< More than a calibration may be off, or what remains is too much.
  } verdict = Verdict::Kept;
  std::string reason;  ///< One sentence with figures.

  hal::Pose X_KC = hal::Pose::Identity();  ///< Corrected camera C in the calibrated one K.
  double depth_scale = 1.0;                ///< Factor on every depth.
  double focal_scale = 1.0;                ///< Factor on both focal lengths.
  double shift_m = 0.0;            ///< Of points in the workspace by the correction, root mean square.
  double sigma_m = 0.0;            ///< Standard deviation of what remains there, root mean square.
  double residual_before_m = 0.0;  ///< Of the arm's points, root mean square.
  double residual_m = 0.0;         ///< The same after the correction.
  int arm_points = 0, floor_points = 0;

  [[nodiscard]] bool applied() const { return verdict == Verdict::Applied; }
  [[nodiscard]] double position_m() const { return X_KC.translation().norm(); }
  [[nodiscard]] double rotation_rad() const;
  /// Depths and focal length of a frame, in place; nothing where no correction is applied.
  void correct(hal::DepthFrame& frame) const;
};

/// Pose of the camera (6), scale of the depths and focal length from an image of the resting arm and of the
/// floor at z = 0 of its base: robust least squares from points to the model's surface, with the
/// calibration's own accuracy as prior, so that what is not observable keeps its value. A radial distortion,
/// an offset of every link and of the floor are estimated beside them and left as they are. `frame`: the mean
/// of `frames` depth images with the robot in it, nobody else near; `workspace_B`: where accuracy matters.
/// Deterministic. About 10 ms.
[[nodiscard]] CameraCorrection estimate_correction(const hal::DepthFrame& frame, int frames,
                                                   const hal::Pose& X_BK, const hal::RobotModel& robot,
                                                   const hal::JointVector& q_rad,
                                                   const hal::HandPosture& hand, const NoiseModel& noise,
                                                   const hal::Aabb& workspace_B,
                                                   const CorrectionConfig& config);

}  // namespace colift::perception
