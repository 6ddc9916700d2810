#pragma once

#include <optional>
#include <span>
#include <string>

#include "perception/organised_cloud.hpp"
#include "perception/scene.hpp"
#include "perception/thesis/pcl_cloud.hpp"
#include "perception/thesis/thesis_config.hpp"

namespace colift::perception {

/// The points that a frame is compared by: depth limits, pass-through and voxel grid, nothing removed.
[[nodiscard]] PclCloud thesis_cloud(const OrganisedCloud& frame, const ThesisConfig& config);

/// Points of `current` that are farther than partner_difference_m from every point of `reference`
/// (PCL's SegmentDifferences).
[[nodiscard]] PclCloud changed_points(const PclCloud& reference, const PclCloud& current,
                                      const ThesisConfig& config);

/// Where the partner holds the object (thesis section 5.3.3): the mean of the partner_points changed points
/// that are nearest to the object. `reference` is the cloud before the partner came, `object` the target's
/// points in it; all in W. Its covariance is the scatter of those points, since the palm is somewhere among
/// them.
///
/// Nothing if fewer points changed, or if those lie farther than partner_reach_m from the object on average:
/// then somebody is in view and nobody holds the object. `because`, if given, is told which, with the
/// numbers.
[[nodiscard]] std::optional<PartnerGrasp> thesis_partner(const PclCloud& reference, const PclCloud& current,
                                                         std::span<const Eigen::Vector3f> object,
                                                         const ThesisConfig& config,
                                                         std::string* because = nullptr);

}  // namespace colift::perception
