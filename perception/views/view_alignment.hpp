#pragma once

#include <string>

#include "hal/config/range.hpp"
#include "hal/types/geometry.hpp"
#include "perception/noise_model.hpp"
#include "perception/organised_cloud.hpp"

namespace colift::perception {

/// How one view is aligned to another. SI units.
struct AlignmentConfig {
  double position_sigma_m = 0.01;
  double rotation_sigma_deg = 0.6;
  double gate_m = 0.08;
  double max_normal_deg = 25.0;
  double surface_sigma_m = 0.003;
  int stride = 6;
  int correlated_px = 18;
  int min_points = 300;
  int iterations = 20;

  template <class Visitor>
  void visit(Visitor& v) {
    v("position_sigma_m", position_sigma_m, hal::Range{1e-5, 1},
      "Standard deviation of the camera's position along each axis, assumed before the alignment (m).");
    v("rotation_sigma_deg", rotation_sigma_deg, hal::Range{1e-3, 30},
      "The same of its orientation about each axis (deg).");
    v("gate_m", gate_m, hal::Range{0.005, 0.5}, "Max distance of a point from the other view's surface (m).");
    v("max_normal_deg", max_normal_deg, hal::Range{1, 90},
      "Max angle between the surface's normals in the two views (deg).");
    v("surface_sigma_m", surface_sigma_m, hal::Range{1e-5, 0.05},
      "Standard deviation of a measured point about a surface, beside the depth noise (m).");
    v("stride", stride, hal::Range{1, 64}, "Every n-th pixel of every n-th row is used.");
    v("correlated_px", correlated_px, hal::Range{1, 64},
      "Width of the patch of pixels that share their error, those of quantisation and silhouettes too (px).");
    v("min_points", min_points, hal::Range{20, 100000}, "Min number of points that both views show.");
    v("iterations", iterations, hal::Range{2, 100}, "Max number of iterations.");
  }
};

/// How one view has to be moved to agree with another.
struct ViewAlignment {
  bool enough = false;   ///< Both views show enough in common; else nothing below is known.
  int points = 0;        ///< That both views show.
  double receded = 0.0;  ///< Part of the moving view's points that lie behind what the fixed one shows there.
  hal::Pose X = hal::Pose::Identity();   ///< Takes points of the moving view (W) onto the fixed one.
  double before_m = 0.0, after_m = 0.0;  ///< Median distance of the points from the other view's surface.
  double shift_m = 0.0;                  ///< By X, root mean square over the points.
  double sigma_m = 0.0;                  ///< Standard deviation of that which remains, root mean square.
  /// X in its standard deviations, as far as what both views show tells: by chance about 2.4, seldom 5.
  double sigmas = 0.0;
  std::string reason;  ///< One sentence with figures.

  [[nodiscard]] double position_m() const { return X.translation().norm(); }
  [[nodiscard]] double rotation_rad() const { return Eigen::AngleAxisd(X.linear()).angle(); }
};

/// Point-to-plane alignment (Chen and Medioni 1991) with projective association (Blais and Levine 1995) of
/// what both views show at rest; things that only one shows lie outside of the gate or its weights (Tukey's
/// biweight). The prior keeps directions that the scene does not show. `moving` and `fixed` in W, without the
/// robot. Deterministic; 1 to 3 ms for two Kinect images.
[[nodiscard]] ViewAlignment align_views(const OrganisedCloud& fixed, const OrganisedCloud& moving,
                                        const NoiseModel& noise, const AlignmentConfig& config);

}  // namespace colift::perception
