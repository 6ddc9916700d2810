#pragma once

#include <vector>

#include "perception/scene.hpp"
#include "perception/surfaces/plane_growing.hpp"

namespace colift::perception {

/// Cylinders of the object. Looked for in its connected parts after the faces that are too wide to be a strip
/// of a cylinder are taken away. A part is a cylinder when its points lie on one as well as the noise model
/// tells, over enough of its arc, and clearly better than on two perpendicular faces. Of a part that is none
/// as a whole, such as a pipe with the narrow blocks that it lies on, each large strip suggests a cylinder;
/// what lies around such a one is tried alone, where most of its rim is free. A cylinder's pixels get the
/// label kCylinder; faces of which little is left lose the rest to kFree. `first_edge`: faces from this index
/// on are edge faces, which are no strips of a cylinder either.
[[nodiscard]] std::vector<Cylinder> find_cylinders(ObjectImage& image, std::vector<Face>& faces,
                                                   std::size_t first_edge, const Ground& ground,
                                                   const SurfaceConfig& config);

/// Widest strip (m) of a cylinder that the noise lets pass for a plane.
[[nodiscard]] double widest_strip(const ObjectImage& image, double inverse_depth,
                                  const SurfaceConfig& config);

}  // namespace colift::perception
