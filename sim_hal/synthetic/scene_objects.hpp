#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "sim_hal/synthetic/hash_random.hpp"
#include "sim_hal/synthetic/scenes.hpp"

namespace colift::sim_hal {

/// An object on its own, in its frame T: origin on the floor under the middle of its footprint, Tz up.
struct ObjectModel {
  std::string name;
  std::vector<Shape> parts;     ///< Label::Target, without overlap.
  std::vector<Shape> supports;  ///< What it lies on, Label::Clutter.
  std::vector<TrueFace> faces;
  std::vector<TrueCylinder> cylinders;
  std::vector<Vec3> graspable;

  /// Centre of gravity at uniform density, from the parts.
  [[nodiscard]] Vec3 cog() const;
  /// Axis-aligned bounds of parts and supports in T.
  [[nodiscard]] hal::Aabb bounds() const;
};

/// An object of a kind with random measures.
[[nodiscard]] ObjectModel make_object(ObjectKind kind, Draws& draws);

/// Corners of the smallest box around a shape that is aligned with it; not for half spaces.
[[nodiscard]] std::vector<Vec3> corners(const Shape& shape);

/// The same view with a sixteenth of the pixels, for quick looks.
[[nodiscard]] inline hal::CameraIntrinsics coarse(const hal::CameraIntrinsics& k) {
  constexpr int kStep = 4;
  return {k.width / kStep, k.height / kStep, k.fx / kStep, k.fy / kStep, k.cx / kStep, k.cy / kStep};
}

}  // namespace colift::sim_hal
