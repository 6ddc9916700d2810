#pragma once

#include <cstddef>
#include <vector>

#include "hal/config/range.hpp"
#include "perception/noise_model.hpp"
#include "perception/reference_image.hpp"
#include "perception/scene.hpp"

namespace colift::perception {

/// Which points of the object's surface are followed.
struct SurfaceSamplingConfig {
  int candidates = 16000;
  double min_window_coverage = 0.7;
  double max_roughness = 1.3;
  double min_view_cosine = 0.17;
  double noise_floor_m = 0.0005;
  double correlated_pixels = 6.0;
  double curved_tilt_factor = 2.5;

  template <class Visitor>
  void visit(Visitor& v) {
    v("candidates", candidates, hal::Range{100, 1e6},
      "Number of the object's pixels at which a normal is estimated; more cost time.");
    v("min_window_coverage", min_window_coverage, hal::kFraction,
      "Min fraction of the window around a pixel that shows the object.");
    v("max_roughness", max_roughness, hal::Range{0.1, 100},
      "Max residual of a window in which the object is smooth, in expected noise.");
    v("min_view_cosine", min_view_cosine, hal::kFraction,
      "Min cosine between a surface's normal and the ray; steeper surfaces have ragged depth (0.17: 80 "
      "degrees).");
    v("noise_floor_m", noise_floor_m, hal::Range{0, 0.1}, "Error that calibration and rounding leave (m).");
    v("correlated_pixels", correlated_pixels, hal::Range{1, 1000},
      "Number of neighbouring pixels that share their noise and count as one.");
    v("curved_tilt_factor", curved_tilt_factor, hal::Range{1, 100},
      "Factor on the uncertainty of a normal where the surface is curved.");
  }
};

/// Points of the object's surface with their normals, in camera frame C, as the reference image shows them:
/// what ObjectFollower aligns to each frame. One array per coordinate, all of the same length.
struct SurfaceSamples {
  std::vector<float> x, y, z;            ///< Point (m).
  std::vector<float> nx, ny, nz;         ///< Unit normal, away from the camera.
  std::vector<float> sigma_m;            ///< Noise of one frame's distance to the tangent plane (m).
  std::vector<float> tilt_rad;           ///< Uncertainty of the normal.
  hal::Vec3 middle = hal::Vec3::Zero();  ///< Mean of the object's points in C.
  double radius_m = 0.0;                 ///< Root mean square distance of the samples from it.

  [[nodiscard]] std::size_t size() const { return x.size(); }
};

/// At most `count` samples. A normal is the plane fit over the largest window around a pixel in which the
/// object is flat within its noise: a plane is linear in inverse depth, where the sensor's noise is alike
/// everywhere. All orientations get an equal part of the samples as far as they have pixels, so that the few
/// pixels of legs and sides hold what a large top cannot (normal-space sampling, Rusinkiewicz and Levoy
/// 2001).
[[nodiscard]] SurfaceSamples sample_surface(const ReferenceImage& reference, const Target& target,
                                            const NoiseModel& noise, int count,
                                            const SurfaceSamplingConfig& config = {});

}  // namespace colift::perception
