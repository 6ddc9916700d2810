#pragma once

#include <cstdint>
#include <string>

#include "hal/config/range.hpp"
#include "hal/types/geometry.hpp"

namespace colift::perception {

/// Parameters of the thesis's perception (sections 5.3.1, 5.3.2.1 and 5.3.3). The thesis names the stages and
/// leaves the numbers open, except the 100 points of the partner's grasp; the numbers here are PCL's usual
/// ones for a Kinect.
struct ThesisConfig {
  // the space in which the object is expected
  double depth_min_m = 0.3;
  double depth_max_m = 3.5;
  hal::Vec3 crop_min_m{-10.0, -10.0, -10.0};
  hal::Vec3 crop_max_m{10.0, 10.0, 10.0};

  double voxel_leaf_m = 0.01;

  double ground_distance_m = 0.015;
  int ground_iterations = 1000;
  int ground_refits = 10;
  double ground_min_fraction = 0.1;

  int outlier_neighbours = 50;
  double outlier_sigmas = 1.0;

  double cluster_tolerance_m = 0.05;
  int cluster_min_points = 100;

  double surface_distance_m = 0.01;
  int surface_iterations = 300;
  double surface_rest_fraction = 0.1;
  int surface_min_points = 30;
  double rectangle_min_fill = 0.7;
  double rectangle_cell_m = 0.02;
  double rectangle_min_size_m = 0.015;

  double mesh_edge_m = 0.05;
  int mesh_gap_px = 8;

  std::string partner_reference = "scene";
  double partner_difference_m = 0.03;
  int partner_points = 100;
  double partner_reach_m = 0.1;
  double partner_margin_m = 0.3;
  int frames_per_sight = 10;
  double person_cell_m = 0.05;
  int person_min_points = 5;

  int seed = 1;

  template <class Visitor>
  void visit(Visitor& v) {
    using hal::Range;
    v("depth_min_m", depth_min_m, Range{0.0, 20.0}, "Min depth along the viewing axis (m).");
    v("depth_max_m", depth_max_m, Range{0.1, 20.0}, "Max depth along the viewing axis (m).");
    v("crop_min_m", crop_min_m, Range{-1000.0, 1000.0},
      "Lower corner in W of the space in which the object is expected (m).");
    v("crop_max_m", crop_max_m, Range{-1000.0, 1000.0}, "Upper corner in W of that space (m).");
    v("voxel_leaf_m", voxel_leaf_m, Range{0.0, 0.2},
      "Side of the voxels in which points are averaged; 0 keeps every point (m).");
    v("ground_distance_m", ground_distance_m, Range{0.001, 0.2},
      "Max distance of the ground's points from its plane (m).");
    v("ground_iterations", ground_iterations, Range{10, 100000},
      "Max number of RANSAC iterations for the ground.");
    v("ground_refits", ground_refits, Range{0, 100},
      "Number of least-squares fits of the ground to its inliers; 1 is PCL's usual, 10 leave nothing to the "
      "seed.");
    v("ground_min_fraction", ground_min_fraction, hal::kFraction,
      "Min fraction of the points that lie on the ground.");
    v("outlier_neighbours", outlier_neighbours, Range{0, 500},
      "Number of neighbours whose mean distance decides whether a point is an outlier; 0 keeps all points.");
    v("outlier_sigmas", outlier_sigmas, Range{0.0, 20.0},
      "Min mean distance of an outlier above the average, in standard deviations.");
    v("cluster_tolerance_m", cluster_tolerance_m, Range{0.002, 0.5},
      "Min gap that separates objects (m); 0.02 loses the legs of a table seen from above, 0.05 keeps them.");
    v("cluster_min_points", cluster_min_points, Range{1, 1e6}, "Min number of points of an object.");
    v("surface_distance_m", surface_distance_m, Range{0.001, 0.1},
      "Max distance of a face's points from it (m).");
    v("surface_iterations", surface_iterations, Range{10, 100000},
      "Max number of RANSAC iterations for one face.");
    v("surface_rest_fraction", surface_rest_fraction, hal::kFraction,
      "Fraction of the object's points left at which the search for faces ends.");
    v("surface_min_points", surface_min_points, Range{3, 1e6},
      "Min number of points of a face and of a rectangle.");
    v("rectangle_min_fill", rectangle_min_fill, hal::kFraction,
      "Covered fraction below which a rectangle is split.");
    v("rectangle_cell_m", rectangle_cell_m, Range{0.002, 0.2},
      "Side of the cells that measure the covered fraction; at least two voxels are used (m).");
    v("rectangle_min_size_m", rectangle_min_size_m, Range{0.0, 1.0}, "Min short side of a rectangle (m).");
    v("mesh_edge_m", mesh_edge_m, Range{0.0, 0.5},
      "Max edge of the triangles that make the object's cloud an obstacle; 0: its points alone are (m).");
    v("mesh_gap_px", mesh_gap_px, Range{0, 64}, "Max width of missing pixels that triangles span (px).");
    v("partner_reference", partner_reference, hal::Choices{"object", "scene"},
      "Cloud that a frame is compared with for the partner's grasp: the object's, as in the thesis, where "
      "all else above the ground is new, or the whole scene's.");
    v("partner_difference_m", partner_difference_m, Range{0.001, 0.5},
      "Min distance of a changed point from the reference cloud (m).");
    v("partner_points", partner_points, Range{1, 1e5},
      "Number of changed points nearest to the object whose mean is the partner's grasp.");
    v("partner_reach_m", partner_reach_m, Range{0.001, 1000.0},
      "Max mean distance of these points from the object; the thesis has no such limit (m).");
    v("partner_margin_m", partner_margin_m, Range{0.0, 10.0},
      "Distance from the object's box beyond which nobody is looked for in a running camera (m).");
    v("frames_per_sight", frames_per_sight, Range{1, 1000},
      "The partner is looked for in one of so many frames: the chain takes some 0.3 s with voxels of 5 mm.");
    v("person_cell_m", person_cell_m, Range{0.005, 1.0},
      "Side of the cells that join changed points to a person, of whom the arm keeps away (m).");
    v("person_min_points", person_min_points, Range{1, 1000}, "Min number of changed points of such a cell.");
    v("seed", seed, Range{0, 2147483647}, "Seed of the random samples; the same seed gives the same bits.");
  }
};

}  // namespace colift::perception
