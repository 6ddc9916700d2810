#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>
#include <vector>

#include "hal/depth_camera.hpp"
#include "hal/types/geometry.hpp"

namespace colift::perception {

using hal::Pose;
using hal::Vec3;

/// One pose of the arm and where the camera saw the emitter then. B = base of the robot, H = palm.
struct EmitterSample {
  Pose X_BH = Pose::Identity();                          ///< By the arm's own kinematics.
  Eigen::Vector2d pixel = Eigen::Vector2d::Zero();       ///< In the infrared image, without lens distortion.
  Eigen::Matrix2d covariance = Eigen::Matrix2d::Zero();  ///< Of the pixel (px^2); zero: the default's.
  std::optional<double> depth_m;                         ///< Along Cz, near the emitter.
};

/// What is sought: the camera in the base, the emitter in the palm, and what may be released with them.
struct EmitterModel {
  Eigen::Matrix3d R_CB = Eigen::Matrix3d::Identity();
  Vec3 t_CB = Vec3::Zero();      ///< Origin of B in C (m).
  Vec3 p_H = Vec3::Zero();       ///< Emitter in the palm frame (m).
  hal::CameraIntrinsics camera;  ///< Of the infrared image.
  double depth_scale = 1.0;      ///< measured depth = scale * true depth + offset
  double depth_offset_m = 0.0;

  [[nodiscard]] Vec3 in_camera(const Pose& X_BH) const { return R_CB * (X_BH * p_H) + t_CB; }
  [[nodiscard]] Pose X_BC() const;
  void set_X_BC(const Pose& X_BC);
};

/// What is worth how much.
struct EmitterNoise {
  double pixel_px = 0.3;  ///< Of a spot, per axis, at least.
  double arm_m = 0.001;   ///< Of the arm's absolute position, per axis.
};

/// Standard deviation of a pixel residual at a distance (px): the spot's own and the arm's error as seen.
[[nodiscard]] double pixel_sigma(const EmitterSample& sample, const EmitterModel& model, double z_m,
                                 const EmitterNoise& noise);
/// Of a depth near the emitter (m).
[[nodiscard]] double depth_sigma(double z_m);

/// What is estimated beside camera pose and emitter, each with a prior: nothing; scale and offset of the
/// depth (the depth's point is not quite the emitter); f, cx and cy too.
enum class Released { Nothing, DepthTerms, Intrinsics };

/// Which of the samples count, and in what way.
struct EmitterRows {
  std::vector<int> samples;
  std::vector<bool> use_depth;  ///< For each sample of all; empty: no depth.
  bool huber = false;
  Released released = Released::Nothing;
  double emitter_prior_m = 0.0;  ///< > 0: the emitter is about so far from the palm's origin.
};

inline constexpr int kPoseParameters = 9;  ///< Rotation (in C), translation, emitter.
inline constexpr int kAllParameters = 14;  ///< f, cx, cy, depth scale and offset after them.
using Normal = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, kAllParameters, kAllParameters>;
using Step = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, kAllParameters, 1>;

/// J^T J, J^T r and the sum of squares of the weighted rows at a model; infinite cost where a point lies
/// behind the camera.
struct Linearised {
  Normal H;
  Step g;
  double cost = 0.0;
  int rows = 0;
};
[[nodiscard]] Linearised linearise(std::span<const EmitterSample> samples, const EmitterModel& model,
                                   const EmitterModel& prior, const EmitterRows& rows,
                                   const EmitterNoise& noise);

/// Levenberg-Marquardt on these rows, the rotation on its tangent space. Returns the cost at the end.
double refine(std::span<const EmitterSample> samples, const EmitterRows& rows, const EmitterNoise& noise,
              const EmitterModel& prior, int most_steps, EmitterModel& model);

/// Residual of a sample's pixel (px); infinite behind the camera.
[[nodiscard]] Eigen::Vector2d pixel_residual(const EmitterSample& sample, const EmitterModel& model);

/// d(point in B) / d(parameters) of a point that the camera measures perfectly: how wrong it will be placed.
[[nodiscard]] Eigen::Matrix<double, 3, 6> placing_jacobian(const EmitterModel& model, const Vec3& p_B);

}  // namespace colift::perception
