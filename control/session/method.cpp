#include "control/session/method.hpp"

#include <algorithm>
#include <limits>

namespace colift::control {
namespace {

// Its mean of 100 points comes three times a second and strays by centimetres as the person's arm and body
// come and go among them. Three of them have to agree; one that is missing is no end of a grasp.
constexpr double kDwell_s = 0.6;
constexpr double kLetGo_s = 0.8;
constexpr double kMoved_m = 0.08;

// A rim of 25 mm keeps its points: with voxels of 1 cm one row of them is left, and what lies within 1 cm of
// the top's plane goes to the top. It has but some hundredths of a table's points, so the search for faces
// has to go on when a tenth is left.
constexpr double kVoxel_m = 0.005, kOfFace_m = 0.006, kLeastRectangle_m = 0.008, kRestPart = 0.02;
// The space in which the object is expected, in the robot's base frame: what the arm reaches, and the length
// of an object beyond that. Elsewhere the floor alone would keep the chain busy.
const hal::Vec3 kSpaceMin_m(-0.3, -1.3, -1.5), kSpaceMax_m(2.3, 1.3, 1.9);

}  // namespace

void set_thesis_defaults(Config& config) {
  config.thesis.voxel_leaf_m = kVoxel_m;
  config.thesis.surface_distance_m = kOfFace_m;
  config.thesis.surface_rest_fraction = kRestPart;
  config.thesis.rectangle_min_size_m = kLeastRectangle_m;
  config.thesis.crop_min_m = kSpaceMin_m;
  config.thesis.crop_max_m = kSpaceMax_m;
}

void use_method(Method method, Config& config) {
  if (method != Method::Thesis) return;
  config.decision.weights = planner::SharingWeights::thesis();
  config.decision.max_sideways = std::numeric_limits<double>::infinity();
  config.decision.max_lever_m = std::numeric_limits<double>::infinity();
  perception::TrackerConfig& tracker = config.tracker;
  tracker.dwell_s = std::max(tracker.dwell_s, kDwell_s);
  tracker.let_go_s = std::max(tracker.let_go_s, kLetGo_s);
  tracker.moved_m = std::max(tracker.moved_m, kMoved_m);
}

}  // namespace colift::control
