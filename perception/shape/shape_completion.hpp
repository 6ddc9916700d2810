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

  template <class Visitor>
  void visit(Visitor& v) {
    v("thickness_m", thickness_m, hal::kPositive, "Thickness (m) of a plate whose edge was not seen.");
    v("wall_m", wall_m, hal::kPositive, "Thickness (m) of the walls and bottom of an open box.");
    v("leg_m", leg_m, hal::kPositive, "Side (m) of the square legs of tables and chairs.");
    v("plate_height_m", plate_height_m, hal::kPositive,
      "A level plate lower over the ground than this has no legs (m).");
    v("min_plate_m", min_plate_m, hal::kPositive, "Short side (m) of the smallest table top or chair seat.");
    v("closed_support", closed_support, hal::kFraction,
      "A body is closed below its top when at least this part of what would be its visible sides was seen.");
    v("level_deg", level_deg, hal::Range{0, 45}, "Largest tilt of a top, a seat or a bottom.");
    v("seat_low_m", seat_low_m, hal::kPositive, "Lowest seat of a chair, over the ground (m).");
    v("seat_high_m", seat_high_m, hal::kPositive, "Highest seat of a chair, over the ground (m).");
    v("seat_width_m", seat_width_m, hal::kPositive, "Long side of the largest seat of a chair (m).");
    v("edge_pixels", edge_pixels, hal::kNotNegative, "Standard deviation (pixels) of where an edge is.");
    v("shape_sigma", shape_sigma, hal::kFraction,
      "Standard deviation of what is only inferred, as a part of the size in that direction.");
  }
};

/// What one view implies about the whole object.
struct CompletedShape {
  enum class Kind { Block, Plate, OpenBox, Cylinder, Chair, Mirrored };
  Kind kind = Kind::Mirrored;
  Vec3 cog = Vec3::Zero();                               ///< Centroid at uniform density, in W (m).
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();  ///< Of the centroid (m^2).
  OrientedBox box;      ///< That the whole object fills; third axis nearest to up.
  std::string because;  ///< What was assumed, in a person's words, with numbers.
};

/// Completes the visible side of an object, by the first of these that fits: a cylinder is as its mantle
/// says; a level top over seen sides is a block that goes down to the ground; level top with little below it
/// a plate on four legs; a top of the size and height of a seat with something over it is a chair, symmetric
/// about its middle; upright walls around a low bottom an open box; anything else is mirrored through the
/// middle of its box. Needs points; `surfaces` as found in the same view.
[[nodiscard]] CompletedShape complete_shape(const OrganisedCloud& cloud, const Target& target,
                                            const std::vector<Surface>& surfaces, const Ground& ground,
                                            const NoiseModel& noise, const CompletionConfig& config = {});

/// A word for it: "block", "plate on legs".
[[nodiscard]] const char* name_of(CompletedShape::Kind kind);

}  // namespace colift::perception
