#pragma once

#include <optional>
#include <string>
#include <vector>

#include "hal/config/range.hpp"
#include "perception/noise_model.hpp"
#include "perception/organised_cloud.hpp"
#include "perception/reference_image.hpp"
#include "perception/scene.hpp"

namespace colift::perception {

struct MotionConfig {
  int samples = 2000;
  int iterations = 8;
  double max_step_m = 0.03;
  double min_fraction = 0.15;

  template <class Visitor>
  void visit(Visitor& v) {
    v("samples", samples, hal::Range{100, 20000}, "Points of the object that are followed.");
    v("iterations", iterations, hal::Range{1, 50}, "Steps of the alignment per frame.");
    v("max_step_m", max_step_m, hal::Range{0.005, 0.2}, "Largest motion between two frames (m).");
    v("min_fraction", min_fraction, hal::kFraction, "Least part of the points that has to be seen again.");
  }
};

/// Where the object is now against the reference.
struct ObjectMotion {
  hal::Pose X_WTnow_WTref =
      hal::Pose::Identity();  ///< Moves a point of the reference to where it is now, in W.
  double seen = 0.0;          ///< Part of the followed points that were found again (0 to 1).
  double rms_m = 0.0;         ///< Of the distances that remain.
  Eigen::Matrix<double, 6, 6> covariance =
      Eigen::Matrix<double, 6, 6>::Zero();  ///< Twist (linear, angular), W, about the object's centre.

  /// Rise of a point of the reference along the unit vector `up`.
  [[nodiscard]] double rise(const hal::Vec3& p_W, const hal::Vec3& up) const {
    return up.dot(X_WTnow_WTref * p_W - p_W);
  }
  /// Angle between the object's up axis now and then (rad).
  [[nodiscard]] double tilt(const hal::Vec3& up) const;
};

/// Follows the target through small motions (lift, tilt, slip) by aligning its reference points to each
/// frame, point to plane with projective association; pixels of hands, partner and other intruders are left
/// out by robust weights and by the mask. Keeps its buffers: one object, one thread. About a millisecond a
/// frame.
class ObjectFollower {
 public:
  /// Errors: BadInput (target without pixels).
  [[nodiscard]] static hal::Result<ObjectFollower> make(const ReferenceImage& reference, const Target& target,
                                                        const NoiseModel& noise, const MotionConfig& config);

  /// Aligns from the last known motion. nullopt with the reason in `because` when too little was seen again
  /// or what was found is no small motion; the last motion then stays.
  [[nodiscard]] std::optional<ObjectMotion> update(const OrganisedCloud& current,
                                                   std::string* because = nullptr);

  [[nodiscard]] const ObjectMotion& last() const { return last_; }

 private:
  ObjectFollower() = default;
  ObjectMotion last_;
  struct Impl;
  std::shared_ptr<Impl> impl_;
};

}  // namespace colift::perception
