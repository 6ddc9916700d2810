#pragma once

#include <cstddef>
#include <vector>

#include "perception/noise_model.hpp"
#include "perception/reference_image.hpp"
#include "perception/scene.hpp"

namespace colift::perception {

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
                                            const NoiseModel& noise, int count);

}  // namespace colift::perception
