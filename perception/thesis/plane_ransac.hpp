#pragma once

#include <optional>
#include <vector>

#include "perception/thesis/pcl_cloud.hpp"

namespace colift::perception {

struct PlaneSearch {
  double distance_m = 0.015;  ///< Up to here a point lies on the plane.
  int iterations = 1000;
  int seed = 1;
  int refits = 1;  ///< Least-squares fits to the plane's points, each to the points of the one before.
};

/// A plane with the points of a cloud that lie on it (ascending indices). The sign of the normal is not
/// decided.
struct PlaneFit {
  hal::Plane plane;
  std::vector<int> inliers;
  double rms_m = 0.0;
};

/// The plane with the most points among those of `indices`, by PCL's RANSAC (99 % sure of a sample without
/// outliers, fewer trials when that comes early) and a least-squares fit to its points. Nothing if no three
/// points span a plane.
///
/// PCL draws samples from a generator that it seeds with a constant, or with the time on request; a seed of
/// one's own is not offered. Here the generator is seeded with `seed`, so that a run can be repeated and also
/// varied.
[[nodiscard]] std::optional<PlaneFit> largest_plane(const PclCloud& cloud, const std::vector<int>& indices,
                                                    const PlaneSearch& search);

/// As above, among all points.
[[nodiscard]] std::optional<PlaneFit> largest_plane(const PclCloud& cloud, const PlaneSearch& search);

}  // namespace colift::perception
