#pragma once

#include <cstdint>
#include <limits>
#include <vector>

#include "hal/config/range.hpp"
#include "perception/ground_and_target/components.hpp"
#include "perception/ground_and_target/image_border.hpp"
#include "perception/noise_model.hpp"
#include "perception/scene.hpp"

namespace colift::perception {

/// Which pieces of the image belong to one object.
struct FragmentConfig {
  int min_pixels = 40;
  double hole_gap_m = 0.015;
  double hanging_gap_m = 0.09;
  double standing_gap_m = 0.07;
  double under_fraction = 0.8;

  template <class Visitor>
  void visit(Visitor& v) {
    v("min_pixels", min_pixels, hal::Range{1, 1e6}, "Smaller regions are speckle.");
    v("hole_gap_m", hole_gap_m, hal::kNotNegative,
      "Regions this near in space, plus one quantisation step, are one object with a hole in its depth.");
    v("hanging_gap_m", hanging_gap_m, hal::kNotNegative,
      "A small region high above the ground belongs to its neighbour in the image if it is this near to it.");
    v("standing_gap_m", standing_gap_m, hal::kNotNegative,
      "A region that floats at most this high over another one, footprints overlapping, stands on it.");
    v("under_fraction", under_fraction, hal::kFraction,
      "A small region belongs to the larger one over it when this part of its footprint lies under that "
      "one's.");
  }
};

/// A connected region of the image above the ground, or several that belong together.
struct Fragment {
  std::vector<std::int32_t> labels;  ///< Regions of the Components that it consists of.
  std::size_t pixels = 0;
  double area_m2 = 0.0;  ///< Frontal area: pixels times their size at their depth.
  double mean_depth_m = 0.0;
  double min_height_m = std::numeric_limits<double>::infinity();
  double max_height_m = -std::numeric_limits<double>::infinity();
  int u_min = 1 << 20, u_max = -1, v_min = 1 << 20, v_max = -1;
  int cut_left = 0, cut_right = 0, cut_top = 0, cut_bottom = 0;  ///< Pixels on the rim of the seen image.
  Aabb box;                                                      ///< In W.
  std::vector<std::int64_t> cells;  ///< Footprint: sorted 4 cm cells of the ground plane.
};

/// How far a fragment reaches over the ground: diagonal of its footprint's bounding box (m).
[[nodiscard]] double footprint_span(const Fragment& fragment);

/// Regions with their statistics; small ones are left out.
[[nodiscard]] std::vector<Fragment> describe_fragments(const OrganisedCloud& cloud,
                                                       const Components& components, const Ground& ground,
                                                       const ImageBorder& border,
                                                       const FragmentConfig& config);

/// Joins regions that are parts of one object: nearer than a hole, standing on one another, or a leg under a
/// plate.
[[nodiscard]] std::vector<Fragment> join_fragments(std::vector<Fragment> fragments,
                                                   const OrganisedCloud& cloud, const Components& components,
                                                   const NoiseModel& noise, const FragmentConfig& config);

}  // namespace colift::perception
