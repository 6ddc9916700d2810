#pragma once

#include <string>
#include <vector>

#include "hal/config/range.hpp"
#include "perception/noise_model.hpp"
#include "perception/organised_cloud.hpp"
#include "perception/scene.hpp"

namespace colift::perception {

/// What is assumed of the parts of an object that the camera does not see.
struct CompletionConfig {
  double thickness_m = 0.025;
  double wall_m = 0.015;
  double leg_m = 0.04;
  double plate_height_m = 0.15;
  double min_plate_m = 0.20;
  double closed_support = 0.5;
  double level_deg = 8.0;
  double seat_low_m = 0.35;
  double seat_high_m = 0.55;
  double seat_width_m = 0.65;
  double edge_pixels = 0.7;
  double shape_sigma = 0.08;
  double min_cylinder_fraction = 0.5;
  double min_cylinder_span = 0.8;
  double min_above_fraction = 0.06;
  double above_clearance_m = 0.05;
  double load_sigma = 0.15;
  double max_lean_sine = 0.14;
  double min_top_fraction = 0.12;
  double same_level_tolerance_m = 0.02;
  double max_edge_width_m = 0.08;
  double side_cosine = 0.96;
  double side_tolerance_m = 0.02;
  double standing_gap_m = 0.04;
  double min_back_height_m = 0.05;
  double back_fill = 0.45;
  double back_fill_sigma = 0.15;
  double back_thickness_sigma = 0.25;
  double back_facing = 0.35;
  double min_back_fill = 0.2;
  double max_gaps = 0.5;
  double min_gaps = 0.55;
  double min_panel_m = 0.10;
  double min_top_of_whole = 0.6;
  double part_sigma = 0.5;
  double hidden_part_sigma = 0.6;
  double min_wall_fraction = 0.25;
  double max_bottom_height = 0.25;
  double min_inward_fraction = 0.15;
  double vertical_sigma_m = 0.002;
  double stray_fraction = 0.004;
  int side_columns = 24;
  int side_rows = 12;

  template <class Visitor>
  void visit(Visitor& v) {
    v("thickness_m", thickness_m, hal::kPositive, "Thickness (m) of a plate whose edge was not seen.");
    v("wall_m", wall_m, hal::kPositive, "Thickness (m) of the walls and bottom of an open box.");
    v("leg_m", leg_m, hal::kPositive, "Side (m) of the square legs of tables and chairs.");
    v("plate_height_m", plate_height_m, hal::kPositive,
      "Min height over the ground of a level plate that has legs (m).");
    v("min_plate_m", min_plate_m, hal::kPositive, "Min short side (m) of a table top or chair seat.");
    v("closed_support", closed_support, hal::kFraction,
      "Min fraction of a closed body's visible sides that has to be seen; below, it is a plate on legs.");
    v("level_deg", level_deg, hal::Range{0, 45}, "Max tilt of a top, a seat or a bottom (deg).");
    v("seat_low_m", seat_low_m, hal::kPositive, "Min height of a chair's seat over the ground (m).");
    v("seat_high_m", seat_high_m, hal::kPositive, "Max height of a chair's seat over the ground (m).");
    v("seat_width_m", seat_width_m, hal::kPositive, "Max long side of a chair's seat (m).");
    v("edge_pixels", edge_pixels, hal::kNotNegative, "Standard deviation of the position of an edge (px).");
    v("shape_sigma", shape_sigma, hal::kFraction,
      "Standard deviation of what is only inferred, as a fraction of the size in that direction.");
    v("min_cylinder_fraction", min_cylinder_fraction, hal::kFraction,
      "Min fraction of the surfaces' area that a cylinder makes up for the object to be one.");
    v("min_cylinder_span", min_cylinder_span, hal::kFraction,
      "Min length of a cylinder, as a fraction of the footprint's, for the object to be it whatever else is "
      "seen.");
    v("min_above_fraction", min_above_fraction, hal::kFraction,
      "Min fraction of the points above a top that is a back, or a thing that stands on it.");
    v("above_clearance_m", above_clearance_m, hal::Range{0, 1}, "Min height over a top of these points (m).");
    v("load_sigma", load_sigma, hal::kFraction,
      "Standard deviation of the mass of things on a plate, as a fraction of the whole.");
    v("max_lean_sine", max_lean_sine, hal::kFraction,
      "Max sine of the lean of an upright face (0.14: 8 degrees).");
    v("min_top_fraction", min_top_fraction, hal::kFraction,
      "Min fraction of the footprint that a top covers; rims of open boxes cover less.");
    v("same_level_tolerance_m", same_level_tolerance_m, hal::Range{0, 1},
      "Max difference in height of the pieces of one top (m).");
    v("max_edge_width_m", max_edge_width_m, hal::Range{0, 1},
      "Max width of the edge face of a plate (m); below it the sides of a closed body are searched.");
    v("side_cosine", side_cosine, hal::kFraction,
      "Min cosine between the normal of a face and the direction of the side that it is (0.96: 16 degrees).");
    v("side_tolerance_m", side_tolerance_m, hal::Range{0, 1},
      "Max distance of what the camera saw from the side of a closed body, beside the noise (m).");
    v("standing_gap_m", standing_gap_m, hal::Range{0, 1},
      "Max gap between the ground and an upright cylinder that stands on it, beside the noise (m).");
    v("min_back_height_m", min_back_height_m, hal::Range{0, 1},
      "Min height over the seat of the points of a back (m).");
    v("back_fill", back_fill, hal::kFraction,
      "Part of a chair's back, width times height, that is material, where it was not seen from the front.");
    v("back_fill_sigma", back_fill_sigma, hal::kFraction,
      "Standard deviation of that; half of it where it was seen.");
    v("back_thickness_sigma", back_thickness_sigma, hal::kFraction,
      "Standard deviation of the thickness of a back, as a fraction of thickness_m.");
    v("back_facing", back_facing, hal::kFraction,
      "Min cosine between the line of sight and a back's normal for the back to be seen from the front.");
    v("min_back_fill", min_back_fill, hal::kFraction,
      "Min fraction of a back that is seen from the front; with less it is the post of one seen from its "
      "edge.");
    v("max_gaps", max_gaps, hal::kFraction,
      "Max fraction of a top at which the camera looks through it; above, it is no top.");
    v("min_gaps", min_gaps, hal::kFraction,
      "Min fraction of the object's box that is seen to be empty, for an object of parts with nothing "
      "behind them.");
    v("min_panel_m", min_panel_m, hal::kPositive,
      "Min short side of a face below a top that is a side or a shelf, not a leg (m).");
    v("min_top_of_whole", min_top_of_whole, hal::kFraction,
      "Min fraction of the footprint that a top on legs covers.");
    v("part_sigma", part_sigma, hal::kFraction,
      "Standard deviation of the mass of a seen part, as a fraction of it: its thickness is inferred.");
    v("hidden_part_sigma", hidden_part_sigma, hal::kFraction,
      "The same of a part that is taken to be on the hidden side.");
    v("min_wall_fraction", min_wall_fraction, hal::kFraction,
      "Min fraction of the walls of an open box that is seen.");
    v("max_bottom_height", max_bottom_height, hal::kFraction,
      "Max height of the bottom of an open box, as a fraction of the object's.");
    v("min_inward_fraction", min_inward_fraction, hal::kFraction,
      "Min fraction of an open box's faces that look inwards or are its bottom.");
    v("vertical_sigma_m", vertical_sigma_m, hal::Range{0, 1},
      "Standard deviation of heights that a plane of many pixels gives, beside the noise (m).");
    v("stray_fraction", stray_fraction, hal::Range{0, 0.49},
      "Fraction of the points at each end of the object's extent that may be strays.");
    v("side_columns", side_columns, hal::Range{1, 1000},
      "Number of columns of points at which each side of a closed body is tested.");
    v("side_rows", side_rows, hal::Range{1, 1000}, "Number of rows of these points.");
  }
};

/// What one view implies about the whole object.
struct CompletedShape {
  enum class Kind { Block, Plate, OpenBox, Cylinder, Chair, Parts, Mirrored };
  Kind kind = Kind::Mirrored;
  Vec3 cog = Vec3::Zero();                               ///< Centroid at uniform density, in W (m).
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();  ///< Of the centroid (m^2).
  OrientedBox box;     ///< That the whole object fills; third axis nearest to up.
  std::string reason;  ///< What was assumed, in a person's words, with numbers.
};

/// Completes the visible side of an object, by the first of these that fits: a cylinder is as its mantle
/// says; a level top over seen sides is a block that goes down to the ground; level top with little below it
/// a plate on four legs; a top of the size and height of a seat with something over it is a chair, symmetric
/// about its middle; upright walls around a low bottom an open box; boards, sides and bars between which the
/// camera looks through are parts of their own; anything else is mirrored through the middle of its box.
/// Needs points; `surfaces` as found in the same view.
[[nodiscard]] CompletedShape complete_shape(const OrganisedCloud& cloud, const Target& target,
                                            const std::vector<Surface>& surfaces, const Ground& ground,
                                            const NoiseModel& noise, const CompletionConfig& config = {});

/// A word for it: "block", "plate on legs".
[[nodiscard]] const char* name_of(CompletedShape::Kind kind);

}  // namespace colift::perception
