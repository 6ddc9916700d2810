#pragma once

#include <cstdint>
#include <vector>

#include "hal/config/range.hpp"
#include "perception/ground_and_target/block_planes.hpp"
#include "perception/ground_and_target/image_border.hpp"
#include "perception/noise_model.hpp"
#include "perception/scene.hpp"

namespace colift::perception {

/// What counts as a wall.
struct WallConfig {
  double min_width_m = 1.2;
  double min_height_m = 1.0;
  double tolerance_m = 0.02;

  template <class Visitor>
  void visit(Visitor& v) {
    v("min_width_m", min_width_m, hal::kPositive, "An upright plane narrower than this is no wall.");
    v("min_height_m", min_height_m, hal::kPositive,
      "An upright plane that ends lower than this above the ground is no wall, unless the image cuts it at "
      "the top.");
    v("tolerance_m", tolerance_m, hal::kNotNegative,
      "Distance from a wall, beside the noise, that still belongs to it.");
  }
};

/// An upright plane with the part of it that was seen.
struct Wall {
  Plane plane;
  Vec3 along = Vec3::UnitX();       ///< Level unit vector in the plane.
  double from_m = 0.0, to_m = 0.0;  ///< Extent: along . p of its ends.
};

/// Upright planes that are too wide and too high to be carried: walls, partitions, cupboards. What stands
/// before a wall and touches it is freed from it by taking the wall's pixels away.
[[nodiscard]] std::vector<Wall> find_walls(const OrganisedCloud& cloud, const std::vector<BlockPlane>& blocks,
                                           const Ground& ground, const ImageBorder& border,
                                           const NoiseModel& noise, const WallConfig& config);

/// Clears the mask at pixels that lie on one of the walls. Returns how many were cleared.
std::size_t clear_walls(const OrganisedCloud& cloud, const std::vector<Wall>& walls, const NoiseModel& noise,
                        const WallConfig& config, std::vector<std::uint8_t>& mask);

}  // namespace colift::perception
