#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "hal/types/geometry.hpp"
#include "perception/organised_cloud.hpp"

namespace colift::bench {

/// What somebody who knows PCL would write for an organised image: the ground by SACSegmentation on every
/// 64th pixel, then OrganizedConnectedComponentSegmentation of what stands above it.
struct ExpertTarget {
  hal::Plane ground;                  ///< W, the normal upwards.
  std::vector<std::uint32_t> pixels;  ///< Of the component with the largest area, ascending.
};

/// nullopt: no plane, or nothing on it.
[[nodiscard]] std::optional<ExpertTarget> expert_target(const hal::DepthFrame& frame, const hal::Pose& X_WC);

/// How many points of `now` lie in voxels of `cell_m` in which `before` has none, both cut to a box:
/// OctreePointCloudChangeDetector.
[[nodiscard]] std::size_t octree_changes(const perception::OrganisedCloud& before,
                                         const perception::OrganisedCloud& now, const hal::Aabb& box_W,
                                         double cell_m);

/// The same by SegmentDifferences with a distance of `distance_m`, between voxels of 1 cm.
[[nodiscard]] std::size_t cropped_differences(const perception::OrganisedCloud& before,
                                              const perception::OrganisedCloud& now, const hal::Aabb& box_W,
                                              double distance_m);

}  // namespace colift::bench
