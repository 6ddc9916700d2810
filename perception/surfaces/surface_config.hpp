#pragma once

#include "hal/config/range.hpp"

namespace colift::perception {

/// How planes grow over the object's pixels.
struct GrowingConfig {
  double max_seed_misfit = 1.7;
  double max_cell_misfit = 2.6;
  double max_cell_offset = 1.1;
  int min_cell_pixels = 12;
  double max_merge_misfit = 1.25;
  double min_bow_cosine = 0.985;
  double min_bow_width_m = 0.04;
  double max_bow_residual = 1.3;

  template <class Visitor>
  void visit(Visitor& v) {
    v("max_seed_misfit", max_seed_misfit, hal::Range{0.1, 100},
      "Max mean square residual of a window from which a plane grows, in variances of the noise.");
    v("max_cell_misfit", max_cell_misfit, hal::Range{0.1, 100},
      "Max mean square residual of a cell that joins a plane, in variances of the noise.");
    v("max_cell_offset", max_cell_offset, hal::Range{0.1, 100},
      "Max mean residual of a cell that joins a plane, in standard deviations of the noise.");
    v("min_cell_pixels", min_cell_pixels, hal::Range{3, 64},
      "Min number of free pixels of a cell that joins.");
    v("max_merge_misfit", max_merge_misfit, hal::Range{1, 100},
      "Max ratio of the squared residuals of two planes as one to those of the two planes.");
    v("min_bow_cosine", min_bow_cosine, hal::kFraction,
      "Min cosine between the normals of the pieces of one bowed face (0.985: 10 degrees).");
    v("min_bow_width_m", min_bow_width_m, hal::Range{0, 1}, "Min width of the pieces of a bowed face (m).");
    v("max_bow_residual", max_bow_residual, hal::Range{0, 100},
      "Max root mean square residual of a bowed face, in units of tolerance_m.");
  }
};

/// How rectangles cover the pixels of a face.
struct CoverConfig {
  double max_outside_fraction = 0.12;
  double min_known_fraction = 0.35;
  double min_width_px = 2.0;
  double same_direction_cosine = 0.9986;

  template <class Visitor>
  void visit(Visitor& v) {
    v("max_outside_fraction", max_outside_fraction, hal::kFraction,
      "Max fraction of a face's rim that may lie outside of its rectangle.");
    v("min_known_fraction", min_known_fraction, hal::kFraction,
      "Min fraction of a rectangle that has to be covered, whatever is unknown.");
    v("min_width_px", min_width_px, hal::Range{0, 100}, "Min number of pixels across a rectangle (px).");
    v("same_direction_cosine", same_direction_cosine, hal::kFraction,
      "Min cosine between the sides of two rectangles that are joined (0.9986: 3 degrees).");
  }
};

/// How narrow faces along the edges of wide ones are found.
struct EdgeFaceConfig {
  double level_cosine = 0.9986;
  double same_face_cosine = 0.9;
  double same_face_distance_m = 0.04;
  double min_gain = 60;
  double min_depth_sigma = 0.8;
  double gate_sigma = 4.0;

  template <class Visitor>
  void visit(Visitor& v) {
    v("level_cosine", level_cosine, hal::kFraction,
      "Min cosine between up and the normal of a face that counts as level (0.9986: 3 degrees).");
    v("same_face_cosine", same_face_cosine, hal::kFraction,
      "Min cosine between a known face and the narrow face that it makes unnecessary.");
    v("same_face_distance_m", same_face_distance_m, hal::Range{0, 1}, "Max distance between these two (m).");
    v("min_gain", min_gain, hal::kNotNegative,
      "Min reduction of the squared residuals by a narrow face, in variances of the noise.");
    v("min_depth_sigma", min_depth_sigma, hal::kNotNegative,
      "Min mean distance of its pixels behind the wide face, in standard deviations of the noise.");
    v("gate_sigma", gate_sigma, hal::Range{0.1, 100},
      "Max residual of a pixel that takes part in the fit, in standard deviations of the noise.");
  }
};

/// How cylinders are searched in the object's connected parts.
struct CylinderSearchConfig {
  int max_points = 500;
  int min_part_pixels = 150;
  int max_parts = 16;
  double inlier_sigma = 3.0;
  double min_inlier_fraction = 0.7;
  double end_cosine = 0.85;
  double min_length_radii = 1.0;
  double same_axis_cosine = 0.999;
  int max_strips = 4;
  double min_strip_ratio = 12.0;
  double tube_radii = 0.15;
  double min_face_fraction = 0.5;
  double max_open_rim = 0.6;  ///< 0.1 for a pipe on blocks, near 1 for the edge of a box.
  double near_sigma = 6.0;
  double min_near_fraction = 0.7;
  double min_shared_fraction = 0.15;
  double min_rest_fraction = 0.6;
  double strip_sag_sigma = 3.0;
  int quick_points = 100;
  int judge_points = 250;
  double jump_base_m = 0.012;
  double jump_sigma = 3.0;
  double jump_steps = 1.5;

  template <class Visitor>
  void visit(Visitor& v) {
    v("max_points", max_points, hal::Range{30, 100000},
      "Max number of a part's points that a cylinder is fitted to; more cost time.");
    v("min_part_pixels", min_part_pixels, hal::Range{10, 1e6}, "Min number of pixels of a connected part.");
    v("max_parts", max_parts, hal::Range{1, 1000}, "Max number of parts that are tried, largest first.");
    v("inlier_sigma", inlier_sigma, hal::Range{0.1, 20},
      "Max distance of a cylinder's pixels from its mantle, in standard deviations of the noise.");
    v("min_inlier_fraction", min_inlier_fraction, hal::kFraction,
      "Min fraction of a part's pixels, without its flat ends, that lie on the cylinder.");
    v("end_cosine", end_cosine, hal::kFraction,
      "Min cosine between the axis and the normal of a face that is a flat end of the cylinder.");
    v("min_length_radii", min_length_radii, hal::Range{0, 100}, "Min length of a cylinder, in radii.");
    v("same_axis_cosine", same_axis_cosine, hal::kFraction, "Min cosine between two axes that count as one.");
    v("max_strips", max_strips, hal::Range{0, 100},
      "Max number of strips of a part that suggest a cylinder.");
    v("min_strip_ratio", min_strip_ratio, hal::Range{1, 1000},
      "Min length of a strip that suggests a cylinder alone, in its widths.");
    v("tube_radii", tube_radii, hal::Range{0, 10},
      "Distance beside the mantle of a suggested cylinder within which pixels are tried with it, in radii.");
    v("min_face_fraction", min_face_fraction, hal::kFraction,
      "Min fraction of a face around a suggested cylinder for its pixels to be tried with it.");
    v("max_open_rim", max_open_rim, hal::kFraction,
      "Max fraction of a cylinder's rim at which the object continues without a jump of depth.");
    v("near_sigma", near_sigma, hal::Range{0.1, 100},
      "Max distance from a found cylinder of the pixels of faces that it replaces, in standard deviations.");
    v("min_near_fraction", min_near_fraction, hal::kFraction,
      "Min fraction of such a face that lies so near.");
    v("min_shared_fraction", min_shared_fraction, hal::kFraction,
      "Min fraction of a face that lies so near for the pixels of the face on the cylinder to be the "
      "cylinder's.");
    v("min_rest_fraction", min_rest_fraction, hal::kFraction,
      "Min fraction of its pixels that a face keeps beside a cylinder; below, the face is dropped.");
    v("strip_sag_sigma", strip_sag_sigma, hal::Range{0.1, 100},
      "Sagitta of the widest strip of a cylinder that passes for a plane, in standard deviations of the "
      "noise.");
    v("quick_points", quick_points, hal::Range{10, 100000}, "Number of points with which axes are compared.");
    v("judge_points", judge_points, hal::Range{10, 100000},
      "Half the number of points by which a cylinder is judged.");
    v("jump_base_m", jump_base_m, hal::kNotNegative,
      "Max depth difference of neighbouring pixels of one part, fixed part (m).");
    v("jump_sigma", jump_sigma, hal::kNotNegative, "The same, in standard deviations of the depth noise.");
    v("jump_steps", jump_steps, hal::kNotNegative, "The same, in quantisation steps.");
  }
};

/// Which rectangles and cylinders are found on the target.
struct SurfaceConfig {
  double tolerance_sigma = 2.5;
  double tolerance_m = 0.003;
  int min_pixels = 40;
  double min_width_m = 0.010;
  double min_area_m2 = 0.002;
  double max_normal_sigma_deg = 3.0;
  double fill_threshold = 0.80;
  double min_fill = 0.60;
  int max_splits = 6;
  double max_edge_m = 0.08;
  double min_edge_view_deg = 8.0;
  double cylinder_min_radius_m = 0.015;
  double cylinder_max_radius_m = 0.15;
  double cylinder_min_arc_deg = 90.0;
  double cylinder_max_misfit = 1.5;
  double cylinder_advantage = 0.95;
  GrowingConfig growing;
  CoverConfig cover;
  EdgeFaceConfig edge_faces;
  CylinderSearchConfig cylinders;

  template <class Visitor>
  void visit(Visitor& v) {
    v("tolerance_sigma", tolerance_sigma, hal::kPositive,
      "Max distance of a pixel from its surface, in standard deviations of the depth noise.");
    v("tolerance_m", tolerance_m, hal::kNotNegative,
      "Unevenness of surfaces and lens distortion, added to that distance (m).");
    v("min_pixels", min_pixels, hal::Range{10, 10000}, "Min number of pixels of a rectangle.");
    v("min_width_m", min_width_m, hal::kNotNegative, "Min short side of a rectangle (m).");
    v("min_area_m2", min_area_m2, hal::kNotNegative,
      "Min area of a rectangle (m^2); a hand cannot grasp less.");
    v("max_normal_sigma_deg", max_normal_sigma_deg, hal::kPositive,
      "Max standard deviation of a rectangle's normal by depth noise (deg).");
    v("fill_threshold", fill_threshold, hal::kFraction, "Covered fraction below which a rectangle is split.");
    v("min_fill", min_fill, hal::kFraction,
      "Covered fraction below which a rectangle is dropped after all splits.");
    v.renamed("least_fill", "min_fill");
    v("max_splits", max_splits, hal::Range{0, 8}, "Max depth of splits of a rectangle.");
    v("max_edge_m", max_edge_m, hal::kPositive,
      "Max width of a narrow face along the edge of another face (m).");
    v("min_edge_view_deg", min_edge_view_deg, hal::Range{0, 90},
      "Min angle between the view and a narrow face for it to be searched (deg).");
    v("cylinder_min_radius_m", cylinder_min_radius_m, hal::kPositive, "Min radius of a cylinder (m).");
    v("cylinder_max_radius_m", cylinder_max_radius_m, hal::kPositive, "Max radius of a cylinder (m).");
    v("cylinder_min_arc_deg", cylinder_min_arc_deg, hal::Range{30, 180},
      "Min visible arc of a cylinder (deg).");
    v("cylinder_max_misfit", cylinder_max_misfit, hal::kPositive,
      "Max root mean square residual of a cylinder, in standard deviations of the depth noise.");
    v("cylinder_advantage", cylinder_advantage, hal::kFraction,
      "Max ratio of the squared residuals of a cylinder to those of two perpendicular faces.");
    v("growing", growing, "How planes grow over the object's pixels.");
    v("cover", cover, "How rectangles cover the pixels of a face.");
    v("edge_faces", edge_faces, "How narrow faces along the edges of wide ones are found.");
    v("cylinders", cylinders, "How cylinders are searched.");
  }
};

}  // namespace colift::perception
