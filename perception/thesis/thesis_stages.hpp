#pragma once

#include <optional>
#include <vector>

#include "perception/organised_cloud.hpp"
#include "perception/scene.hpp"
#include "perception/thesis/pcl_cloud.hpp"
#include "perception/thesis/thesis_config.hpp"

namespace colift::perception {

// The stages of the thesis's target extraction (section 5.3.1) one by one, so that each can be timed and
// tested. thesis_scene() calls them in this order. Same input and config: same bits.

/// The seen points of a frame whose depth along the viewing axis lies within the limits.
[[nodiscard]] PclCloud points_in_depth_range(const OrganisedCloud& frame, const ThesisConfig& config);

/// Pass-through filters along x, y and z of W.
[[nodiscard]] PclCloud pass_through(const PclCloud& cloud, const ThesisConfig& config);

/// One point per voxel: the mean of the points in it. A cloud too wide for PCL's 31-bit voxel numbers is cut
/// into parts along voxel faces, where PCL itself would give up and hand the cloud back as it was.
[[nodiscard]] PclCloud voxel_grid(const PclCloud& cloud, const ThesisConfig& config);

/// The largest plane, its normal towards the eye, and the points above it.
struct GroundSplit {
  Ground ground;
  PclCloud above;
};

/// Nothing if no plane is found at all; whether it is large enough is the caller's question.
[[nodiscard]] std::optional<GroundSplit> split_at_ground(const PclCloud& cloud, const Vec3& eye_W,
                                                         const ThesisConfig& config);

/// Statistical outlier removal.
[[nodiscard]] PclCloud without_outliers(const PclCloud& cloud, const ThesisConfig& config);

/// Euclidean clusters of at least cluster_min_points points, largest first.
[[nodiscard]] std::vector<PclCloud> euclidean_clusters(const PclCloud& cloud, const ThesisConfig& config);

}  // namespace colift::perception
