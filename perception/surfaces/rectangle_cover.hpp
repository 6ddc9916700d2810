#pragma once

#include <vector>

#include "perception/scene.hpp"
#include "perception/surfaces/plane_growing.hpp"

namespace colift::perception {

struct FaceRectangle {
  Rectangle rectangle;
  int face = -1;
  int pixels = 0;
};

/// Rectangles that cover the pixels of one face and nothing that the camera saw to be empty: the one of least
/// area first; when less than the threshold of it is covered, it is cut in two where that parts covered from
/// empty places best, and each part is tried again. Where the camera saw nothing, or something nearer, a
/// rectangle may well go on: such places count neither as covered nor as empty. Sides are the median of what
/// lies outermost along them, since edges in depth images are ragged.
void cover_face(const OrganisedCloud& cloud, const ObjectImage& image, const Face& face, int label,
                const std::vector<std::uint32_t>& pixels, const SurfaceConfig& config,
                std::vector<FaceRectangle>& rectangles);

/// The object's pixels by label; pixels without a face are left out, and those of faces that are not wanted.
[[nodiscard]] std::vector<std::vector<std::uint32_t>> pixels_by_face(const ObjectImage& image,
                                                                     const std::vector<Face>& faces,
                                                                     const std::vector<char>& wanted);

}  // namespace colift::perception
