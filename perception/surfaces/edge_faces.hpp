#pragma once

#include <vector>

#include "perception/surfaces/rectangle_cover.hpp"

namespace colift::perception {

/// Narrow faces along the sides of wide ones, such as the 2.5 cm edge of a table top, which is four pixels
/// high where one depth step is half of its thickness. Such a face has no normal of its own; but it is
/// perpendicular to the wide face, and all pixels along the side speak for its remaining two unknowns. Pixels
/// that the wide face or a small one had taken are given to the edge face where it lies behind the wide
/// face's plane. A level one goes on over connected free pixels in its plane, as the rim of a crate does
/// around its corners. Labels the pixels, appends faces and fits the faces that lost pixels again.
void find_edge_faces(ObjectImage& image, std::vector<Face>& faces,
                     const std::vector<FaceRectangle>& rectangles, const Ground& ground,
                     const SurfaceConfig& config);

}  // namespace colift::perception
