#pragma once

#include <cstdint>
#include <limits>
#include <vector>

#include "hal/config/range.hpp"
#include "perception/footprint.hpp"
#include "perception/ground/image_border.hpp"
#include "perception/noise_model.hpp"
#include "perception/scene.hpp"
#include "perception/target/regions/components.hpp"

namespace colift::perception {

/// Which pieces of the image belong to one object.
struct FragmentConfig {
  int min_pixels = 40;
  double hole_gap_m = 0.015;
  double hanging_gap_m = 0.09;
  double hidden_gap_m = 0.30;
  double max_hidden_area_m2 = 0.01;
  double max_leaning_area_m2 = 0.04;
  double standing_gap_m = 0.07;
  double under_fraction = 0.8;
  double min_hanging_height_m = 0.1;
  double max_leg_width_m = 0.2;
  double height_overlap_m = 0.02;
  double min_standing_overlap = 0.15;
  double max_small_fraction = 0.3;

  template <class Visitor>
  void visit(Visitor& v) {
    v("min_pixels", min_pixels, hal::Range{1, 1e6},
      "Min number of pixels of a region; smaller ones are speckle.");
    v("hole_gap_m", hole_gap_m, hal::kNotNegative,
      "Max distance (m), plus one quantisation step, between regions that are one object with a hole in its "
      "depth.");
    v("hanging_gap_m", hanging_gap_m, hal::kNotNegative,
      "Max distance between a small region above the ground and the neighbour in the image that it hangs on "
      "(m).");
    v("hidden_gap_m", hidden_gap_m, hal::kNotNegative,
      "The same where the joint is hidden (m): of a little region that hangs in the air, and of a slender "
      "one that goes on behind a neighbour which is nearer to the camera.");
    v("max_hidden_area_m2", max_hidden_area_m2, hal::kPositive,
      "Max visible area of such a region; a larger one is a thing of its own (m^2).");
    v("max_leaning_area_m2", max_leaning_area_m2, hal::kNotNegative,
      "Max visible area of a region that would fall over alone (it touches the ground beside its middle, or "
      "is too slender to stand), and so leans on a neighbour within hanging_gap_m (m^2). 0: none does.");
    v("standing_gap_m", standing_gap_m, hal::kNotNegative,
      "Max gap in height between a region and the one, with overlapping footprint, that it stands on (m).");
    v("under_fraction", under_fraction, hal::kFraction,
      "Min fraction of a small region's footprint under a larger region that it belongs to, like a leg.");
    v("min_hanging_height_m", min_hanging_height_m, hal::Range{0, 10},
      "Min height above the ground of a region that does not stand on it (m).");
    v("max_leg_width_m", max_leg_width_m, hal::Range{0, 10},
      "Max width of the footprint of a leg that is not higher than wide (m).");
    v("height_overlap_m", height_overlap_m, hal::Range{0, 1},
      "Max overlap in height, by noise, of a region with the one that it stands on (m).");
    v("min_standing_overlap", min_standing_overlap, hal::kFraction,
      "Min fraction of the smaller footprint that a region shares with the one that it stands on.");
    v("max_small_fraction", max_small_fraction, hal::kFraction,
      "Max number of pixels of a leg or strut, as a fraction of the object's that it belongs to.");
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
  std::vector<std::int64_t> cells;    ///< Footprint: sorted 4 cm cells of the ground plane.
  std::vector<std::int64_t> contact;  ///< Those where it comes near to the ground; empty for what hangs.
};

/// For each region of the Components, whether the fragment consists of it: 1 or 0.
[[nodiscard]] std::vector<std::uint8_t> own_regions(const Fragment& object, const Components& components);

/// 1 for each pixel of the image that belongs to the object, else 0.
[[nodiscard]] std::vector<std::uint8_t> own_pixels(const OrganisedCloud& cloud, const Components& components,
                                                   const Fragment& object);

/// The least rectangle around a fragment's footprint, on the axes of hal::tangents (m).
[[nodiscard]] FlatRectangle footprint_rectangle(const Fragment& fragment);

/// How far a fragment reaches over the ground: diagonal of its footprint's bounding box (m).
[[nodiscard]] double footprint_span(const Fragment& fragment);

/// Least distance between the footprints of two fragments on the ground (m), to a cell of 4 cm.
[[nodiscard]] double footprint_gap(const Fragment& a, const Fragment& b);

/// Regions with their statistics; small ones are left out.
[[nodiscard]] std::vector<Fragment> describe_fragments(const OrganisedCloud& cloud,
                                                       const Components& components, const Ground& ground,
                                                       const ImageBorder& border,
                                                       const FragmentConfig& config);

/// Joins regions that are parts of one object: nearer than a hole, standing on one another, or a leg under a
/// plate.
[[nodiscard]] std::vector<Fragment> join_fragments(std::vector<Fragment> fragments,
                                                   const OrganisedCloud& cloud, const Components& components,
                                                   const Ground& ground, const NoiseModel& noise,
                                                   const FragmentConfig& config);

}  // namespace colift::perception
