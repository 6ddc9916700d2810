#pragma once

#include "hal/config/range.hpp"

namespace colift::perception {

/// Which rectangles and cylinders are found on the target.
struct SurfaceConfig {
  double tolerance_sigma = 2.5;
  double tolerance_m = 0.003;
  int min_pixels = 40;
  double min_width_m = 0.010;
  double min_area_m2 = 0.002;
  double max_normal_sigma_deg = 3.0;
  double fill_threshold = 0.80;
  double least_fill = 0.60;
  int max_splits = 6;
  double max_edge_m = 0.08;
  double min_edge_view_deg = 8.0;
  double cylinder_min_radius_m = 0.015;
  double cylinder_max_radius_m = 0.15;
  double cylinder_min_arc_deg = 90.0;
  double cylinder_max_misfit = 1.5;
  double cylinder_advantage = 0.95;

  template <class Visitor>
  void visit(Visitor& v) {
    v("tolerance_sigma", tolerance_sigma, hal::kPositive,
      "Distance of a pixel on a surface, in standard deviations.");
    v("tolerance_m", tolerance_m, hal::kNotNegative,
      "Unevenness of surfaces and lens distortion (m), added to it.");
    v("min_pixels", min_pixels, hal::Range{10, 10000}, "Pixels of the smallest rectangle.");
    v("min_width_m", min_width_m, hal::kNotNegative, "Short side of the narrowest rectangle (m).");
    v("min_area_m2", min_area_m2, hal::kNotNegative,
      "Area of the smallest rectangle (m^2); a hand finds no hold on less.");
    v("max_normal_sigma_deg", max_normal_sigma_deg, hal::kPositive,
      "Rectangles whose normal the depth noise leaves less certain are dropped.");
    v("fill_threshold", fill_threshold, hal::kFraction, "Rectangles that are covered less are split.");
    v("least_fill", least_fill, hal::kFraction,
      "Rectangles that are covered less after all splits are dropped.");
    v("max_splits", max_splits, hal::Range{0, 8}, "How often a rectangle is split again.");
    v("max_edge_m", max_edge_m, hal::kPositive,
      "Width (m) up to which a narrow face is looked for along another's edge.");
    v("min_edge_view_deg", min_edge_view_deg, hal::Range{0, 90},
      "A narrow face turned away more than 90 minus this is not looked for.");
    v("cylinder_min_radius_m", cylinder_min_radius_m, hal::kPositive, "Thinnest cylinder (m).");
    v("cylinder_max_radius_m", cylinder_max_radius_m, hal::kPositive, "Thickest cylinder (m).");
    v("cylinder_min_arc_deg", cylinder_min_arc_deg, hal::Range{30, 180},
      "Arc of a cylinder that has to be seen.");
    v("cylinder_max_misfit", cylinder_max_misfit, hal::kPositive,
      "Root mean square residual of a cylinder, in standard deviations of the depth noise.");
    v("cylinder_advantage", cylinder_advantage, hal::kFraction,
      "A cylinder has to leave less than this part of the squared residuals that two perpendicular faces "
      "leave.");
  }
};

}  // namespace colift::perception
