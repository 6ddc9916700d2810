#pragma once

#include <vector>

#include "perception/surfaces/plane_growing.hpp"

namespace colift::perception {

/// Faces that stand apart and are thinner than the cells that planes grow over: a handle of which five pixels
/// show beside its case. Connected free pixels, at least 8 cm long, are one when nearly all of them lie on a
/// plane as well as the noise model tells, and the object goes on without a jump of depth at little of their
/// rim: the ragged rims of other faces are none. Labels the pixels and appends faces.
void find_strip_faces(ObjectImage& image, std::vector<Face>& faces, const SurfaceConfig& config);

}  // namespace colift::perception
