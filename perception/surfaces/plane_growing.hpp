#pragma once

#include <vector>

#include "perception/surfaces/object_image.hpp"
#include "perception/surfaces/surface_config.hpp"

namespace colift::perception {

/// A plane of the object and the pixels that support it; its index is their label.
struct Face {
  InversePlane plane;
  InverseMoments moments;  ///< Of its pixels.
  bool bowed = false;      ///< Joined from pieces that lean towards each other by a few degrees.
  bool strip = false;      ///< Too narrow for a normal of its own: its lean is assumed (strip_faces).

  [[nodiscard]] double inverse_depth() const { return moments.n > 0 ? moments.q / moments.n : 0.0; }
};

/// Planes of the object's free pixels, grown over cells of the image from the flattest places outwards, first
/// from wide windows, then from narrow ones in what is left. Labels the pixels; faces get labels from
/// faces.size() on. Deterministic: seeds are taken in order of their residual, then of the image.
void grow_faces(ObjectImage& image, std::vector<Face>& faces, const SurfaceConfig& config);

/// Sums over the pixels with a label again and fits every face to them. Faces that lost all their pixels keep
/// their plane.
void refit_faces(const ObjectImage& image, std::vector<Face>& faces);

/// How far a point moves along a bowed face's normal for a metre of depth, 0.25 at least; 1 for even faces.
[[nodiscard]] double slant_of(const Face& face, const ImageGeometry& geometry);

/// Smaller and larger extent (m) of a face, from the spread of its pixels: exact for a filled rectangle.
struct FaceExtent {
  double narrow_m = 0, wide_m = 0;
};
[[nodiscard]] FaceExtent extent_of(const Face& face, const ImageGeometry& geometry);

}  // namespace colift::perception
