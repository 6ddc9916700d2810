#pragma once

#include <cstdint>
#include <vector>

#include "hal/config/range.hpp"
#include "perception/ground/block_planes.hpp"
#include "perception/ground/image_border.hpp"
#include "perception/ground/plane_vote.hpp"
#include "perception/noise_model.hpp"
#include "perception/scene.hpp"

namespace colift::perception {

/// What counts as a wall.
struct WallConfig {
  double min_width_m = 1.2;
  double min_height_m = 1.0;
  double tolerance_m = 0.02;
  double tolerance_sigma = 3.0;
  double max_lean_sine = 0.17;
  double min_block_height_m = 0.05;
  double min_covered_fraction = 0.15;
  int max_gap_blocks = 2;
  int min_blocks = 8;
  double end_margin_m = 0.1;
  double same_wall_cosine = 0.966;
  double same_wall_distance_m = 0.15;
  PlaneVoteConfig vote;

  template <class Visitor>
  void visit(Visitor& v) {
    v("min_width_m", min_width_m, hal::kPositive, "Min width of a wall (m).");
    v("min_height_m", min_height_m, hal::kPositive,
      "Min height of a wall's upper end above the ground (m), unless the image cuts it at the top.");
    v("tolerance_m", tolerance_m, hal::kNotNegative,
      "Max distance of a wall's pixels from its plane, beside the noise (m).");
    v("tolerance_sigma", tolerance_sigma, hal::Range{0, 20},
      "The same, in standard deviations of the depth noise.");
    v("max_lean_sine", max_lean_sine, hal::kFraction,
      "Max sine of a wall's lean from upright (0.17: 10 degrees).");
    v("min_block_height_m", min_block_height_m, hal::Range{0, 10},
      "Image blocks lower over the ground than this belong to no wall (m).");
    v("min_covered_fraction", min_covered_fraction, hal::kFraction,
      "Min fraction of a wall's frame that its image blocks cover; things in front hide the rest.");
    v("max_gap_blocks", max_gap_blocks, hal::Range{1, 100},
      "A wall continues behind a thing that hides fewer image blocks (16 pixels) than this.");
    v("min_blocks", min_blocks, hal::Range{1, 10000}, "Min number of connected image blocks of a wall.");
    v("end_margin_m", end_margin_m, hal::Range{0, 2},
      "Length by which a wall may reach beyond the middle of its last image block (m).");
    v("same_wall_cosine", same_wall_cosine, hal::kFraction,
      "Min cosine between the normals of two planes of one wall that lens distortion bends (0.966: 15 "
      "degrees).");
    v("same_wall_distance_m", same_wall_distance_m, hal::Range{0, 2},
      "Max distance between two planes of one wall (m).");
    v("vote", vote, "How planes of image blocks are gathered into upright planes.");
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
