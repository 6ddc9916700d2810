#include "control/config/config.hpp"

namespace colift::control {
namespace {

// The thesis leaves these numbers open; PCL's usual ones lose the rim of a table, 25 mm high, on which its
// grasps lie. A rim of 25 mm keeps its points: with voxels of 1 cm one row of them is left, and what lies
// within 1 cm of the top's plane goes to the top. It has but some hundredths of a table's points, so the
// search for faces has to go on when a tenth is left.
constexpr double kVoxel_m = 0.005, kOfFace_m = 0.006, kMinRectangle_m = 0.008, kRestPart = 0.02;
// The space in which the object is expected, in the robot's base frame: what the arm reaches, and the length
// of an object beyond that. Elsewhere the floor alone would keep the chain busy.
const hal::Vec3 kSpaceMin_m(-0.3, -1.3, -1.5), kSpaceMax_m(2.3, 1.3, 1.9);

}  // namespace

Config run_defaults() {
  Config config;
  config.support = "floor";  // the arm stands on it; a table as support has to be asked for
  config.candidates.collision.unseen_fraction = 1.0;
  config.candidates.collision.max_unseen_m = 0.25;
  config.candidates.side_clearance_m = 0.03;
  config.candidates.max_turn_deg = 40.0;
  config.decision.max_lever_m = 0.065;
  config.thesis.voxel_leaf_m = kVoxel_m;
  config.thesis.surface_distance_m = kOfFace_m;
  config.thesis.surface_rest_fraction = kRestPart;
  config.thesis.rectangle_min_size_m = kMinRectangle_m;
  config.thesis.crop_min_m = kSpaceMin_m;
  config.thesis.crop_max_m = kSpaceMax_m;
  return config;
}

}  // namespace colift::control
