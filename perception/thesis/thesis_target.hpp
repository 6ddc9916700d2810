#pragma once

#include "perception/thesis/thesis_stages.hpp"

namespace colift::perception {

/// What the thesis's method sees in a frame (sections 5.3.1 and 5.3.2.1): pass-through, voxel grid, the
/// largest plane as ground, outlier removal, the largest Euclidean cluster above the ground as target,
/// rectangles on the target.
///
/// The centre of gravity is the middle of the axis-aligned box, as in the thesis. Its covariance is diagonal
/// with a sixth of the box's size as standard deviation along each axis: three of them reach the box's walls,
/// which the true centre cannot pass by much. `shape` equals `obb`: nothing is completed. `pixels` stays
/// empty; see thesis_pixels().
///
/// Known limits, kept because they are the thesis's: a wall larger than the floor becomes the ground, a
/// person or a wall larger than the object becomes the target, objects that touch are one, and what lies
/// behind an edge is unknown. No ground or no target is told in `because`.
[[nodiscard]] Scene thesis_scene(const OrganisedCloud& frame, const ThesisConfig& config);

/// The target that a list of clusters gives (largest first, at least one).
[[nodiscard]] Target thesis_target(const std::vector<PclCloud>& clusters, const Ground& ground);

/// Pixels of a frame whose point lies in the same voxel as a point of the target, ascending: the target as a
/// mask, to compare with a method that works on the image. Without a voxel grid: pixels whose point is one of
/// the target's.
[[nodiscard]] std::vector<std::uint32_t> thesis_pixels(const OrganisedCloud& frame, const Target& target,
                                                       const ThesisConfig& config);

}  // namespace colift::perception
