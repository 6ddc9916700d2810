#pragma once

#include <cstdint>
#include <vector>

#include "hal/depth_camera.hpp"
#include "sim_hal/mock/shapes.hpp"

namespace colift::sim_hal {

/// A noise-free view of a world, with truth for every pixel. Arrays are row-major, width * height.
struct Rendering {
  hal::CameraIntrinsics intrinsics;
  Pose X_WC = Pose::Identity();
  std::vector<float> depth_m;        ///< Along Cz; NaN where no shape was hit.
  std::vector<float> cos_incidence;  ///< |ray . normal| of the hit; 0 where none.
  std::vector<std::int16_t> shape;   ///< Index of the shape that was hit; -1 where none.
  std::vector<Label> label;          ///< Label of the shape that was hit.
  std::vector<float> reflectivity;   ///< Of every shape of the world, by its index.
};

/// Casts one ray per pixel through the world.
[[nodiscard]] Rendering cast_rays(const World& world, const hal::CameraIntrinsics& intrinsics,
                                  const Pose& X_WC);

/// Pose of a camera at `eye` that looks at `target`, image rows level with the world's z axis.
[[nodiscard]] Pose look_at(const Vec3& eye, const Vec3& target);

}  // namespace colift::sim_hal
