#pragma once

#include <vector>

#include "perception/noise_model.hpp"
#include "perception/organised_cloud.hpp"

namespace colift::planner {

using hal::Vec3;

/// What one depth image says about a point in space.
enum class Sight {
  Free,     ///< The camera looked through it: something farther away was measured there.
  Surface,  ///< At the measured depth, within the noise.
  Hidden,   ///< Behind what was measured.
  Unknown,  ///< Nothing was measured in that direction, or it is out of the picture.
};

/// Free and hidden space of one depth image, as a look-up per point. Rows of missing pixels up to
/// `max_gap_px` long, as the shadow of the projector beside every edge, take the smaller depth of their two
/// ends: what lies behind that counts as hidden, what lies before it as free.
class SeenSpace {
 public:
  SeenSpace(const perception::OrganisedCloud& cloud, const perception::NoiseModel& noise, double sigmas,
            int max_gap_px);

  [[nodiscard]] Sight at(const Vec3& p_W) const { return sight(X_CW_ * p_W); }

  /// The same for points in another frame, without the way over W.
  struct View {
    const SeenSpace& space;
    hal::Pose X_CH;
    [[nodiscard]] Sight at(const Vec3& p_H) const { return space.sight(X_CH * p_H); }
  };
  [[nodiscard]] View from(const hal::Pose& X_WH) const { return {*this, X_CW_ * X_WH}; }

  /// How far in front of what was measured a point lies (m), negative behind it; NaN when unknown.
  [[nodiscard]] double clearance(const Vec3& p_W) const;

  [[nodiscard]] const Vec3& camera() const { return camera_; }

  /// Standard deviation of a depth value at the distance of a point (m).
  [[nodiscard]] double sigma(const Vec3& p_W) const { return noise_.sigma((X_CW_ * p_W).z()); }

 private:
  /// Measured depth at a point in C; NaN when unknown.
  [[nodiscard]] double measured(const Vec3& p_C) const;
  [[nodiscard]] Sight sight(const Vec3& p_C) const;

  hal::CameraIntrinsics intrinsics_;
  hal::Pose X_CW_;
  Vec3 camera_;
  perception::NoiseModel noise_;
  double sigmas_;
  std::vector<float> depth_m_;
};

}  // namespace colift::planner
