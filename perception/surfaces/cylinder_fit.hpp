#pragma once

#include <optional>
#include <span>
#include <vector>

#include "perception/scene.hpp"
#include "perception/surfaces/surface_config.hpp"

namespace colift::perception {

/// A point of the object with what its noise is.
struct SightedPoint {
  Vec3 p = Vec3::Zero();    ///< In W.
  Vec3 ray = Vec3::Zero();  ///< By how much p moves for a metre of depth.
  double sigma_m = 0.0;     ///< Standard deviation of the depth.
};

struct CylinderFit {
  Cylinder cylinder;     ///< Without its length: center is somewhere on the axis.
  double misfit = 0.0;   ///< Root mean square residual in standard deviations, outliers counted at three.
  double arc_rad = 0.0;  ///< Arc that the points cover.
};

/// Distance of a point to a cylinder's mantle (m), positive outside, and the standard deviation that depth
/// noise gives to it.
struct MantleDistance {
  double value_m, sigma_m;
};
[[nodiscard]] MantleDistance distance_to(const Cylinder& cylinder, const SightedPoint& point);

/// Best cylinder along one of the given unit axes, refined in all five parameters (Gauss-Newton with Huber
/// weights on distances over their noise). Nothing where no circle of an allowed radius fits within the
/// allowed misfit over the least arc.
[[nodiscard]] std::optional<CylinderFit> fit_cylinder(std::span<const SightedPoint> points,
                                                      std::span<const Vec3> axes, const Vec3& eye,
                                                      const SurfaceConfig& config);

/// The cylinder without the bias that depth noise gives to one of fit_cylinder(): normals and weights taken
/// at noisy points make it thinner by about twice the variance of the depth over the radius, 2 mm of 30 at
/// 2 m. Taken at the places where the rays meet the cylinder, they do not; but such a fit needs a good start
/// and points of the cylinder alone. Where it leads far away, the given cylinder stays.
[[nodiscard]] Cylinder without_bias(std::span<const SightedPoint> points, const Cylinder& cylinder,
                                    const SurfaceConfig& config);

/// Misfit of the best two perpendicular faces along a cylinder's axis, or of one, to the same points: what
/// the corner of a box or a square leg leaves.
[[nodiscard]] double corner_misfit(std::span<const SightedPoint> points, const Cylinder& cylinder,
                                   const CylinderSearchConfig& config);

}  // namespace colift::perception
