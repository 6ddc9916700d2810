#pragma once

#include <optional>

#include "hal/config/range.hpp"
#include "perception/target/regions/silhouette.hpp"
#include "perception/target/regions/surface_curvature.hpp"

namespace colift::perception {

/// What is as round as a limb or a trunk: radii of 14 to 150 mm; slimness, direction and widths separate a
/// pipe that lies from a leg, and from who lies on the floor. The figures were chosen on random rooms
/// (`colift experiment rooms --seed 405` and 406; those of widths 411; those of ridges and bars `stances
/// --seed 501`), those of frames on ladders
/// (`furniture --seed 251` and 263), all with persons of capsules.
struct LimbShapeConfig {
  double min_curvature_per_m = 6.5;
  double max_curvature_per_m = 70.0;
  double sure_curvature_per_m = 4.5;
  double min_convex = 0.6;
  double headless = 0.75;
  double min_measured = 0.08;
  int min_pieces = 3;
  double min_length_m = 0.25;
  double max_pipe_slimness = 0.45;
  double max_pipe_upward = 0.3;
  double max_pipe_unevenness = 0.2;
  double sure_pipe_width_m = 0.11;
  double max_pipe_ridge_m = 0.035;
  double max_pipe_ridge_sigma = 3.0;
  double min_thickness_m = 0.05;
  int min_bar_pieces = 2;
  double min_bar_measured = 0.03;
  double min_bar_convex = 0.85;
  double min_bar_thickness_m = 0.08;
  double min_bar_diameters = 1.2;
  double max_bar_diameters = 3.4;
  int min_openings = 2;
  double min_opening_m2 = 0.004;
  double max_frame_height_m = 0.6;
  double max_frame_thickness_m = 0.10;
  double min_on_legs_m = 0.55;
  double beam_slab_m = 0.08;
  double max_beam_width_m = 0.12;
  double min_beam_length_m = 0.7;
  double top_slab_m = 0.02;
  double max_top_sigma_m = 0.009;
  double min_top_width_m = 0.2;
  double min_top_cover = 0.75;
  CurvatureConfig curvature;

  template <class Visitor>
  void visit(Visitor& v) {
    v("min_curvature_per_m", min_curvature_per_m, hal::kPositive,
      "Min curvature of what may be a part of a person (1/m): the inverse of its radius.");
    v("max_curvature_per_m", max_curvature_per_m, hal::kPositive, "Max curvature of it (1/m).");
    v("sure_curvature_per_m", sure_curvature_per_m, hal::kNotNegative,
      "Min curvature of it that is known beside the depth noise, 95 % (1/m).");
    v("min_convex", min_convex, hal::kFraction, "Min fraction of its surface that is convex.");
    v("headless", headless, hal::kFraction,
      "Factor of these three limits where the view cuts the upper side, so that there may be a head above "
      "it.");
    v("min_measured", min_measured, hal::kFraction,
      "Min fraction of its pixels on which the curvature could be measured.");
    v("min_pieces", min_pieces, hal::Range{1, 1e4}, "Min number of pieces of its surface, measured.");
    v("min_length_m", min_length_m, hal::kNotNegative,
      "Min length or height of it (m); cans and bottles are shorter.");
    v("max_pipe_slimness", max_pipe_slimness, hal::kFraction,
      "Max ratio of width to length of a round object that is a pipe ...");
    v("max_pipe_upward", max_pipe_upward, hal::kFraction,
      "... and max upward part of its direction: a pipe lies, or leans a little ...");
    v("max_pipe_unevenness", max_pipe_unevenness, hal::kNotNegative,
      "... and max range of the middle 80 % of its widths along it, as a fraction of their median: who lies "
      "on "
      "the floor has a neck, shoulders and legs.");
    v("sure_pipe_width_m", sure_pipe_width_m, hal::kNotNegative,
      "Max median width (m) of what is a pipe however uneven: on blocks, or half hidden.");
    v("max_pipe_ridge_m", max_pipe_ridge_m, hal::kNotNegative,
      "... and max range of the middle 80 % of the heights of its upper side about a straight line (m): "
      "head, chest and "
      "legs of who lies there are not on one ...");
    v("max_pipe_ridge_sigma", max_pipe_ridge_sigma, hal::kNotNegative,
      "... the same in standard deviations of the depth noise, whichever is more.");
    v("min_thickness_m", min_thickness_m, hal::kNotNegative,
      "Min median thickness of its parts across the view (m): a frame of tubes is thinner than a wrist.");
    v("min_bar_pieces", min_bar_pieces, hal::Range{1, 1e4},
      "Min number of measured pieces of what is as round as a bar of its own thickness ...");
    v("min_bar_measured", min_bar_measured, hal::kFraction,
      "... min fraction of its pixels on which the curvature could be measured ...");
    v("min_bar_convex", min_bar_convex, hal::kFraction, "... min fraction of that that is convex ...");
    v("min_bar_thickness_m", min_bar_thickness_m, hal::kNotNegative,
      "... min median thickness of its parts (m): legs of tables and chairs are thinner ...");
    v("min_bar_diameters", min_bar_diameters, hal::kNotNegative,
      "... and min and max of curvature times thickness, 2 for a cylinder: the lower limit ...");
    v("max_bar_diameters", max_bar_diameters, hal::kPositive, "... and the upper one.");
    v("min_openings", min_openings, hal::Range{1, 1000},
      "Min number of openings through a lying object, such as between the rungs of a ladder, that is a frame "
      "and no part of a person ...");
    v("min_opening_m2", min_opening_m2, hal::kNotNegative, "... their min area (m^2) ...");
    v("max_frame_height_m", max_frame_height_m, hal::kNotNegative,
      "... max height of it above the ground (m; 0: no frame is told from a limb) ...");
    v("max_frame_thickness_m", max_frame_thickness_m, hal::kNotNegative,
      "... and max median thickness of its parts across the view (m): the thighs and the trunk of who lies "
      "there with his hands behind his head are thicker (thigh: 0.12 m, 5th percentile, DIN 33402-2).");
    v("min_on_legs_m", min_on_legs_m, hal::kNotNegative,
      "Higher than who lies on his side: what is higher than this (m) may be a trestle or a drum ...");
    v("beam_slab_m", beam_slab_m, hal::kNotNegative,
      "What of an object is this far below its top at most (m) is a beam on legs, such as a trestle's, and "
      "no back ...");
    v("max_beam_width_m", max_beam_width_m, hal::kNotNegative,
      "... if it is no wider than this over the ground (m) ...");
    v("min_beam_length_m", min_beam_length_m, hal::kPositive, "... and no shorter than this (m).");
    v("top_slab_m", top_slab_m, hal::kNotNegative,
      "What is this far below its top at most (m) is the lid of a drum ...");
    v("max_top_sigma_m", max_top_sigma_m, hal::kNotNegative,
      "... where the depth noise is less than this (m) ...");
    v("min_top_width_m", min_top_width_m, hal::kPositive,
      "... if it is at least as wide as this over the ground (m) ...");
    v("min_top_cover", min_top_cover, hal::kFraction, "... and covers this fraction of the whole.");
    v("curvature", curvature, "How the curvature of a surface is measured.");
  }
};

/// What is round like a part of a person.
struct LimbShape {
  double radius_m = 0.0;  ///< Of a cylinder with the median curvature.
  double length_m = 0.0;
};

/// An object whose visible surface is mostly as round as a limb or a trunk, and that is no pipe. Furniture
/// and cartons are flat where they are wide enough to measure; nothing is said about what shows no surface as
/// wide as a piece.
[[nodiscard]] std::optional<LimbShape> find_limb(const OrganisedCloud& cloud, const Components& components,
                                                 const Fragment& object, const Silhouette& silhouette,
                                                 const NoiseModel& noise, const LimbShapeConfig& config = {});

}  // namespace colift::perception
