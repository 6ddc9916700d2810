#pragma once

#include <vector>

#include "hal/depth_camera.hpp"
#include "sim_hal/synthetic/shapes.hpp"

// Beneath ray_caster. Everything is done in inverse depth w = 1 / z of the ray (x, y, 1). There a plane is a
// linear function of the pixel, so a convex body with flat faces is hit where the smallest w of the faces
// that the camera is in front of exceeds the largest w of the others: no division, no branch. A quadric adds
// one square root. Values that grow with the row are computed in double, so that single precision along the
// row costs no accuracy that a sensor could see.

namespace colift::sim_hal {

/// x * ray_x + y * ray_y + one.
struct Linear {
  double x = 0.0, y = 0.0, one = 0.0;

  [[nodiscard]] float at_row(double ray_y) const { return static_cast<float>(y * ray_y + one); }
};

/// Columns of a row; none where begin is not before end.
struct Columns {
  int begin = 0, end = 0;
};

/// A convex piece of a shape, in camera coordinates, and the part of the image that it can cover.
struct RayPart {
  enum class Kind { Flat, Cylinder, Sphere };
  Kind kind = Kind::Flat;
  int shape = 0;
  int v_begin = 0;
  std::vector<Columns> rows;  ///< From v_begin on; a column or two more than it covers.
  int fronts = 0, backs = 0;
  Linear front[6], back[6];  ///< w of the planes before and behind which the camera stands.
  float front_distance[6] = {};
  /// Quadric c w^2 + 2 b w + a = 0 with a = |direction|^2 and b^2 - a c = r^2 a - |miss|^2.
  Linear direction[3], miss[3], b;
  double c = 0.0, radius = 0.0;

  /// What it can cover in row v; none outside its rows.
  [[nodiscard]] Columns at_row(int v) const {
    const int i = v - v_begin;
    return i >= 0 && i < static_cast<int>(rows.size()) ? rows[static_cast<std::size_t>(i)] : Columns{};
  }
};

/// The pieces of a shape that are in sight. `index` is what they tell of it, X_CS its pose before the camera.
[[nodiscard]] std::vector<RayPart> ray_parts(const Shape& shape, int index,
                                             const hal::CameraIntrinsics& intrinsics, const Pose& X_CS);

}  // namespace colift::sim_hal
