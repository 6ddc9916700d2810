#pragma once

#include <cstdint>

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

  double partner_difference_m = 0.03;
  int partner_points = 100;
  double partner_reach_m = 0.1;

  int seed = 1;

  template <class Visitor>
  void visit(Visitor& v) {
    using hal::Range;
    v("depth_min_m", depth_min_m, Range{0.0, 20.0},
      "Nearest depth along the viewing axis that is looked at.");
    v("depth_max_m", depth_max_m, Range{0.1, 20.0},
      "Farthest depth along the viewing axis that is looked at.");
    v("crop_min_m", crop_min_m, Range{-1000.0, 1000.0}, "Lowest corner in W of the space that is looked at.");
    v("crop_max_m", crop_max_m, Range{-1000.0, 1000.0},
      "Highest corner in W of the space that is looked at.");
    v("voxel_leaf_m", voxel_leaf_m, Range{0.0, 0.2},
      "Side of the voxels that points are averaged in; 0 keeps every point.");
    v("ground_distance_m", ground_distance_m, Range{0.001, 0.2},
      "Distance from the ground plane up to which a point is ground.");
    v("ground_iterations", ground_iterations, Range{10, 100000},
      "Largest number of RANSAC trials for the ground.");
    v("ground_refits", ground_refits, Range{0, 100},
      "Least-squares fits of the ground to its own points; 1 is PCL's usual, 10 leave nothing to the seed.");
    v("ground_min_fraction", ground_min_fraction, hal::kFraction,
      "Smallest part of the points that a ground plane holds.");
    v("outlier_neighbours", outlier_neighbours, Range{0, 500},
      "Neighbours whose mean distance says whether a point is an outlier; 0 keeps all points.");
    v("outlier_sigmas", outlier_sigmas, Range{0.0, 20.0},
      "Standard deviations above the average mean distance from which on a point is an outlier.");
    v("cluster_tolerance_m", cluster_tolerance_m, Range{0.002, 0.5},
      "Gap that separates objects; 0.02 loses the legs of a table seen from above, 0.05 keeps them.");
    v("cluster_min_points", cluster_min_points, Range{1, 1e6}, "Smallest number of points of an object.");
    v("surface_distance_m", surface_distance_m, Range{0.001, 0.1},
      "Distance from a face up to which a point belongs to it.");
    v("surface_iterations", surface_iterations, Range{10, 100000},
      "Largest number of RANSAC trials for one face.");
    v("surface_rest_fraction", surface_rest_fraction, hal::kFraction,
      "Part of the object's points at which the search for faces ends.");
    v("surface_min_points", surface_min_points, Range{3, 1e6},
      "Smallest number of points of a face and of a rectangle.");
    v("rectangle_min_fill", rectangle_min_fill, hal::kFraction,
      "Covered part below which a rectangle is split.");
    v("rectangle_cell_m", rectangle_cell_m, Range{0.002, 0.2},
      "Side of the cells that measure the covered part; at least two voxels are used.");
    v("rectangle_min_size_m", rectangle_min_size_m, Range{0.0, 1.0},
      "Shortest side of a rectangle that is kept.");
    v("partner_difference_m", partner_difference_m, Range{0.001, 0.5},
      "Distance to the reference cloud from which on a point has changed.");
    v("partner_points", partner_points, Range{1, 1e5},
      "Changed points nearest to the object whose mean is the partner's grasp.");
    v("partner_reach_m", partner_reach_m, Range{0.001, 1000.0},
      "Largest mean distance of these points from the object; the thesis has no such limit.");
    v("seed", seed, Range{0, 2147483647}, "Seed of the random samples; the same seed gives the same bits.");
  }
};

}  // namespace colift::perception
