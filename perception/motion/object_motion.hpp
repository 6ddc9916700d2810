#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "hal/config/range.hpp"
#include "hal/depth_camera.hpp"
#include "hal/types/result.hpp"
#include "perception/motion/moved_object.hpp"
#include "perception/motion/object_motion_samples.hpp"
#include "perception/noise_model.hpp"
#include "perception/organised_cloud.hpp"
#include "perception/reference_image.hpp"
#include "perception/scene.hpp"

namespace colift::perception {

/// How a carried object is followed from frame to frame.
struct MotionConfig {
  int samples = 2000;
  int iterations = 8;
  double max_step_m = 0.03;
  double min_fraction = 0.15;
  int min_samples = 60;
  double gate_sigmas = 3.5;
  double gate_ratio = 0.4;
  int max_search_steps = 3;
  double held_sigma_m = 0.005;
  double held_step_m = 0.01;
  double held_fraction = 0.9;
  double max_shift_m = 0.35;
  double max_turn_rad = 0.6;
  double shared_noise_factor = 2.0;
  SurfaceSamplingConfig sampling;
  MovedObjectConfig moved;

  template <class Visitor>
  void visit(Visitor& v) {
    v("samples", samples, hal::Range{100, 20000}, "Max number of the object's points that are tracked.");
    v("iterations", iterations, hal::Range{1, 50}, "Max iterations of the alignment per frame.");
    v("max_step_m", max_step_m, hal::Range{0.005, 0.2}, "Max motion of the object between two frames (m).");
    v("min_fraction", min_fraction, hal::kFraction,
      "Min fraction of the tracked points that a frame has to show.");
    v("min_samples", min_samples, hal::Range{6, 1e6},
      "Min number of points on smooth surfaces for an object to be tracked.");
    v("gate_sigmas", gate_sigmas, hal::Range{1, 20},
      "Max residual of a point that belongs to the object, in standard deviations.");
    v("gate_ratio", gate_ratio, hal::Range{0.05, 0.95},
      "Ratio of the outlier gate from one iteration to the next.");
    v("max_search_steps", max_search_steps, hal::Range{1, 20},
      "Max search range after missed frames, in units of max_step_m.");
    v("held_sigma_m", held_sigma_m, hal::Range{1e-4, 0.2},
      "Standard deviation of an object against the hand that holds it, in each direction: fingers give way "
      "(m).");
    v("held_step_m", held_step_m, hal::Range{0.001, 0.2},
      "An object that is seen farther than this from where the hand has it is searched this near, too (m) "
      "...");
    v("held_fraction", held_fraction, hal::kFraction,
      "... and is there, where so large a fraction of as many points fits.");
    v("max_shift_m", max_shift_m, hal::Range{0.01, 10},
      "Max distance of the object from where the reference shows it (m).");
    v("max_turn_rad", max_turn_rad, hal::Range{0.01, 3.2},
      "Max angle of the object against the reference (rad).");
    v("shared_noise_factor", shared_noise_factor, hal::Range{1, 100},
      "Factor on the variance of the motion, because points near each other share noise.");
    v("sampling", sampling, "How the tracked points are chosen.");
    v("moved", moved, "How the reference image is redrawn for an object that was moved.");
  }
};

/// Where the object is now against the reference.
struct ObjectMotion {
  hal::Pose X_WTnow_WTref =
      hal::Pose::Identity();  ///< Moves a point of the reference to where it is now, in W.
  double seen = 0.0;          ///< Part of the followed points that were found again (0 to 1).
  double rms_m = 0.0;         ///< Of the distances that remain.
  /// Of this frame alone: twist (linear m, angular rad) in W about the object's centre. A direction that the
  /// view does not hold (a top slides in its plane, a pipe turns about its axis) has a deviation
  /// of kUnknown (m, rad).
  Eigen::Matrix<double, 6, 6> covariance = Eigen::Matrix<double, 6, 6>::Zero();
  hal::Vec3 center_W = hal::Vec3::Zero();  ///< Middle of the followed object now: what the twist is about.

  static constexpr double kUnknown = 0.2;

  /// Rise of a point of the reference along the unit vector `up`.
  [[nodiscard]] double rise(const hal::Vec3& p_W, const hal::Vec3& up) const {
    return up.dot(X_WTnow_WTref * p_W - p_W);
  }
  /// Angle between the object's up axis now and then (rad).
  [[nodiscard]] double tilt(const hal::Vec3& up) const;
  /// Standard deviations of this frame's rise of the centre (m) and of its tilt about the less certain
  /// horizontal axis (rad).
  [[nodiscard]] double rise_sigma(const hal::Vec3& up) const;
  /// The same of the rise of a point of the reference, which its tilt moves too (m).
  [[nodiscard]] double rise_sigma(const hal::Vec3& p_W, const hal::Vec3& up) const;
  [[nodiscard]] double tilt_sigma(const hal::Vec3& up) const;
};

/// Where a hand has the object: a point of the reference, and where the hand's joints say that it is now (W,
/// m).
struct HeldPoint {
  hal::Vec3 ref_W = hal::Vec3::Zero(), now_W = hal::Vec3::Zero();
};

/// Follows the target through small motions (lift, tilt, slip) by aligning its reference points to each
/// frame: point to plane with projective association (Chen and Medioni 1991; Blais and Levine 1995). Every
/// frame is aligned to the reference itself, so errors do not add up. Pixels of hands, partner and other
/// intruders are left out by weights that fall to zero (Tukey's biweight) within a gate that closes from
/// max_step_m to the noise. Directions without hold stay as in the last frame, or go where the hand
/// takes them. Keeps its buffers: one object, one thread. Under a millisecond a frame.
class ObjectFollower {
 public:
  /// Errors: BadInput (target without pixels, image and target disagree), NotFound (too few pixels of the
  /// target lie on surfaces smooth enough to be followed).
  [[nodiscard]] static hal::Result<ObjectFollower> make(const ReferenceImage& reference, const Target& target,
                                                        const NoiseModel& noise, const MotionConfig& config);
  ~ObjectFollower();
  ObjectFollower(ObjectFollower&&) noexcept;
  ObjectFollower& operator=(ObjectFollower&&) noexcept;

  /// Aligns from the last known motion. nullopt with the reason in `because` when too little was seen again
  /// or what was found is no small motion; the last motion then stays, and the next frame is searched wider.
  /// Does not allocate (but for the reason). Only the depths are read.
  [[nodiscard]] std::optional<ObjectMotion> update(const OrganisedCloud& current,
                                                   std::string* reason = nullptr);
  /// The same from a frame of the camera that took the reference; no points in W are needed.
  /// With `held` the position is joined with it by their covariances: along what the view does not hold (the
  /// long side of a box) the object is where the hand has it.
  [[nodiscard]] std::optional<ObjectMotion> update(const hal::DepthFrame& current,
                                                   std::string* reason = nullptr,
                                                   const std::optional<HeldPoint>& held = std::nullopt);

  /// It stands where the reference saw it, or near: what was followed before is forgotten.
  void start_again();

  [[nodiscard]] const ObjectMotion& last() const { return last_; }
  [[nodiscard]] std::size_t samples() const;  ///< Points that are followed.

 private:
  ObjectFollower() = default;
  ObjectMotion last_;
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace colift::perception
