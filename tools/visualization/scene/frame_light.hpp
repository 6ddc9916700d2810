#pragma once

#include <vector>

#include "perception/organised_cloud.hpp"

namespace colift::picture {

/// How brightly each pixel of a depth image is lit by a lamp above the camera's left shoulder, 0 to about 1;
/// NaN where nothing was seen. What lies behind something near it in the image is darkened, so that edges
/// stand out.
///
/// Normals come from a plane fitted to the inverse depth around the pixel: the inverse depth of a plane is
/// linear in the image (1/z = (n . ray) / d), so smoothing it takes the noise and not the shape.
[[nodiscard]] std::vector<float> light_of(const perception::OrganisedCloud& cloud);

}  // namespace colift::picture
