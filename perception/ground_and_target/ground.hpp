#pragma once

#include <optional>
#include <string>

#include "hal/config/range.hpp"
#include "perception/ground_and_target/block_planes.hpp"
#include "perception/ground_and_target/plane_vote.hpp"
#include "perception/noise_model.hpp"
#include "perception/organised_cloud.hpp"
#include "perception/scene.hpp"

namespace colift::perception {

/// What counts as ground.
struct GroundConfig {
  double max_tilt_deg = 12.0;          ///< Used when up is known.
  double max_tilt_unknown_deg = 78.0;  ///< Used when only the camera's own up is known.
  double min_image_fraction = 0.02;
  double min_area_ratio = 0.15;
  double tolerance_sigma = 3.5;
  double tolerance_m = 0.006;
  double parallel_tolerance_deg = 8.0;
  double same_level_tolerance_m = 0.02;
  int fit_stride = 3;
  BlockPlaneConfig blocks;
  PlaneVoteConfig vote;

  template <class Visitor>
  void visit(Visitor& v) {
    v("max_tilt_deg", max_tilt_deg, hal::Range{0, 90},
      "Max angle between the ground's normal and a known up (deg).");
    v("max_tilt_unknown_deg", max_tilt_unknown_deg, hal::Range{0, 90},
      "Max angle between the ground's normal and the image's up, when gravity is unknown (deg).");
    v("min_image_fraction", min_image_fraction, hal::kFraction,
      "Min fraction of the pixels with a depth that the ground covers.");
    v("min_area_ratio", min_area_ratio, hal::kFraction,
      "The lowest level plane is the ground if its area is at least this fraction of the largest level "
      "plane's.");
    v("tolerance_sigma", tolerance_sigma, hal::kPositive,
      "Max distance of an inlier from the ground, in standard deviations of the depth noise.");
    v("tolerance_m", tolerance_m, hal::kNotNegative,
      "Unevenness of the ground and lens distortion, added to that distance (m).");
    v("parallel_tolerance_deg", parallel_tolerance_deg, hal::Range{0, 45},
      "Max angle between the largest level plane and a lower one that may be the ground (deg).");
    v("same_level_tolerance_m", same_level_tolerance_m, hal::Range{0, 1},
      "Min difference in height for one level plane to be lower than another (m).");
    v("fit_stride", fit_stride, hal::Range{1, 16},
      "Every n-th pixel of every n-th row takes part in the fit of the ground.");
    v("blocks", blocks, "How planes are fitted to blocks of the image.");
    v("vote", vote, "How planes of image blocks are gathered into level planes.");
  }
};

/// The ground, where one was found.
struct GroundResult {
  std::optional<Ground> ground;
  std::string reason;  ///< What was found, or why nothing was.
};

/// The plane that things stand on. Level planes are voted by the planes of image blocks; of those with a fair
/// share of the level area the lowest one is the ground, refined on all its pixels with weights of the noise
/// model. `up_W`: unit vector against gravity when it is known; else the image's own up is a weak hint, under
/// which walls in view of a camera that looks level or down never pass. Deterministic.
[[nodiscard]] GroundResult find_ground(const OrganisedCloud& cloud, const std::vector<BlockPlane>& blocks,
                                       const std::optional<Vec3>& up_W, const NoiseModel& noise,
                                       const GroundConfig& config);

}  // namespace colift::perception
