#pragma once

#include <span>
#include <vector>

#include "perception/bodies/body_finder.hpp"

namespace colift::perception {

/// Spheres in W, one array for each number, so that a distance to all of them is computed in a few wide
/// loops.
struct SphereSet {
  std::vector<float> x, y, z, radius_m;

  void clear();
  void add(const hal::Vec3& center_W, double sphere_radius_m);
  [[nodiscard]] std::size_t size() const { return x.size(); }
};

/// Where a body is nearest to a set of spheres.
struct Approach {
  double distance_m = 0.0;                ///< Between the surfaces; negative where they overlap.
  hal::Vec3 point_W = hal::Vec3::Zero();  ///< Of the body.
  std::size_t sphere = 0;
};

/// Smallest distance between points of a body, each with the unobserved space behind it, and spheres. False
/// without points or spheres, and where nothing is nearer than `within_m`.
[[nodiscard]] bool nearest_approach(std::span<const BodyPoint> points, const SphereSet& spheres,
                                    double within_m, Approach& out);

}  // namespace colift::perception
