#pragma once

#include <algorithm>
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

  /// For many points in another frame, without the way over W, in single precision.
  struct View {
    const SeenSpace& space;
    Eigen::Matrix3f R;
    Eigen::Vector3f t;
    /// Whether the point is hidden or unknown.
    [[nodiscard]] bool hides(float x, float y, float z) const {
      const float cz = R(2, 0) * x + R(2, 1) * y + R(2, 2) * z + t.z();
      if (!(cz > 0.0f)) return true;
      const float cx = R(0, 0) * x + R(0, 1) * y + R(0, 2) * z + t.x();
      const float cy = R(1, 0) * x + R(1, 1) * y + R(1, 2) * z + t.y();
      const float scale = 1.0f / cz;
      const float u = space.fx_ * cx * scale + space.cx_, v = space.fy_ * cy * scale + space.cy_;
      const int width = space.intrinsics_.width, height = space.intrinsics_.height;
      if (!(u >= 0.0f && v >= 0.0f && u < static_cast<float>(width) && v < static_cast<float>(height)))
        return true;
      const float depth =
          space.depth_m_[static_cast<std::size_t>(static_cast<int>(v) * width + static_cast<int>(u))];
      if (cz <= depth) return false;
      if (!(depth == depth)) return true;
      return cz - depth > space.sigmas_ * space.noise_.sigma(depth) + space.noise_.step(depth);
    }
  };
  [[nodiscard]] View from(const hal::Pose& X_WH) const {
    const hal::Pose X_CH = X_CW_ * X_WH;
    return {*this, X_CH.linear().cast<float>(), X_CH.translation().cast<float>()};
  }

  /// How far in front of what was measured a point lies (m), negative behind it; NaN when unknown.
  [[nodiscard]] double clearance(const Vec3& p_W) const;

  [[nodiscard]] const Vec3& camera() const { return camera_; }

  /// Standard deviation of a depth value at the distance of a point (m).
  [[nodiscard]] double sigma(const Vec3& p_W) const { return noise_.sigma((X_CW_ * p_W).z()); }

  /// Width of a pixel at the distance of a point (m).
  [[nodiscard]] double pixel_m(const Vec3& p_W) const {
    return std::max(0.0, (X_CW_ * p_W).z()) / intrinsics_.fx;
  }

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
  float fx_, fy_, cx_, cy_;  ///< Of the intrinsics, with half a pixel added to the middle.
};

}  // namespace colift::planner
