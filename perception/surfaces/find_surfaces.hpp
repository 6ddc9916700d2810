#pragma once

#include <vector>

#include "perception/noise_model.hpp"
#include "perception/organised_cloud.hpp"
#include "perception/scene.hpp"
#include "perception/surfaces/surface_config.hpp"

namespace colift::perception {

/// Planar rectangles and cylinders of the object's visible side, largest area first. Needs Target::pixels;
/// without pixels there are no surfaces. Normals point out of the object, towards the camera; u is the longer
/// side. Rectangles do not lie over holes through which the camera saw something behind; fill is the covered
/// part of what could be seen. A cylinder's length is the visible one. Deterministic.
[[nodiscard]] std::vector<Surface> find_surfaces(const OrganisedCloud& cloud, const Target& target,
                                                 const Ground& ground, const NoiseModel& noise,
                                                 const SurfaceConfig& config);

}  // namespace colift::perception
