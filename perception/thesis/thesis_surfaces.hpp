#pragma once

#include <span>
#include <vector>

#include "perception/scene.hpp"
#include "perception/thesis/thesis_config.hpp"

namespace colift::perception {

/// Approximates an object by rectangles (thesis section 5.3.2.1): planes by RANSAC, each taken out of the
/// cloud, until few points remain; around the points of a plane the convex hull and its rectangle of least
/// area; a rectangle that is not covered well enough is halved across its long side, each half with a hull
/// and rectangle of its own, until it is covered or too small. Normals point towards the eye. Largest planes
/// first.
///
/// Covered is measured in cells: `fill` is the part of the rectangle's cells that hold a point. The thesis
/// speaks of density; points per area would depend on distance and slant as well, cells do not.
[[nodiscard]] std::vector<Rectangle> thesis_surfaces(std::span<const Eigen::Vector3f> object,
                                                     const Vec3& eye_W, const ThesisConfig& config);

}  // namespace colift::perception
