#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include "hal/depth_camera.hpp"
#include "sim_hal/synthetic/ray_parts.hpp"
#include "sim_hal/synthetic/shapes.hpp"

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

/// The same for a camera that stands still and sees one world after the other: only pixels on which something
/// moved are cast anew. The images are those of cast_rays(), bit by bit where nothing moves by less than a
/// micrometre from one image to the next, and to a few micrometres elsewhere. Shapes are known by their
/// index.
class RayCaster {
 public:
  RayCaster(const hal::CameraIntrinsics& intrinsics, const Pose& X_WC);

  /// Valid until the next call.
  [[nodiscard]] const Rendering& cast(const World& world);

 private:
  struct Seen {
    Shape shape;  // as it was cast
    bool known = false;
    std::vector<RayPart> parts;
  };

  void take_over(const World& world);
  void mark_stale(const std::vector<RayPart>& parts);
  void cast_row(int v);
  void cast_columns(int v, Columns run);
  void finish(int v, Columns run, float one_plus_y2);
  friend Rendering cast_rays(const World& world, const hal::CameraIntrinsics& intrinsics, const Pose& X_WC);

  Rendering image_;
  std::vector<Seen> seen_;
  std::vector<Label> labels_;         // one place up, of no shape first
  std::vector<std::uint64_t> stale_;  // a bit for every four pixels of a row that are to be cast
  std::size_t words_ = 0;             // of it, for one row
  // of the row that is being cast: rays, what is nearest so far, and what can be in it
  std::vector<float> ray_x_, w_, normal_dot_ray_, shape_;
  std::vector<std::pair<const RayPart*, Columns>> row_parts_;
};

/// Pose of a camera at `eye` that looks at `target`, image rows level with the world's z axis.
[[nodiscard]] Pose look_at(const Vec3& eye, const Vec3& target);

}  // namespace colift::sim_hal
