#pragma once

#include <optional>
#include <string>
#include <vector>

#include "hal/config/range.hpp"
#include "perception/ground/block_planes.hpp"
#include "perception/ground/level_planes.hpp"
#include "perception/ground/plane_vote.hpp"
#include "perception/noise_model.hpp"
#include "perception/organised_cloud.hpp"
#include "perception/scene.hpp"

namespace colift::perception {

/// What counts as ground.
struct GroundConfig {
  double max_tilt_deg = 12.0;          ///< Used when up is known.
  double max_tilt_unknown_deg = 78.0;  ///< Used when only the camera's own up is known.
  double min_image_fraction = 0.02;
  double tolerance_sigma = 3.5;
  double tolerance_m = 0.006;
  int max_tries = 3;
  double min_table_height_m = 0.3;
  double max_table_height_m = 1.3;
  double min_table_area_m2 = 0.08;
  double max_table_tilt_deg = 5.0;
  int fit_stride = 3;
  BlockPlaneConfig blocks;
  PlaneVoteConfig vote;
  LevelPlaneConfig level;

  template <class Visitor>
  void visit(Visitor& v) {
    v("max_tilt_deg", max_tilt_deg, hal::Range{0, 90},
      "Max angle between the ground's normal and a known up (deg).");
    v("max_tilt_unknown_deg", max_tilt_unknown_deg, hal::Range{0, 90},
      "Max angle between the ground's normal and the image's up, when gravity is unknown (deg).");
    v("min_image_fraction", min_image_fraction, hal::kFraction,
      "Min fraction of the pixels with a depth that the ground covers.");
    v("tolerance_sigma", tolerance_sigma, hal::kPositive,
      "Max distance of an inlier from the ground, in standard deviations of the depth noise.");
    v("tolerance_m", tolerance_m, hal::kNotNegative,
      "Unevenness of the ground and lens distortion, added to that distance (m).");
    v("max_tries", max_tries, hal::Range{1, 100},
      "Level planes that are tried, in the order of their evidence, until one explains enough pixels.");
    v("min_table_height_m", min_table_height_m, hal::kPositive,
      "Min height over the ground of a table top that objects may stand on (m).");
    v("max_table_height_m", max_table_height_m, hal::kPositive,
      "Max height over the ground of such a table top (m).");
    v("min_table_area_m2", min_table_area_m2, hal::kPositive, "Min area in view of such a table top (m^2).");
    v("max_table_tilt_deg", max_table_tilt_deg, hal::Range{0, 45},
      "Max angle between such a table top and the ground (deg).");
    v("fit_stride", fit_stride, hal::Range{1, 16},
      "Every n-th pixel of every n-th row takes part in the fit of the ground.");
    v("blocks", blocks, "How planes are fitted to blocks of the image.");
    v("vote", vote, "How planes of image blocks are gathered into level planes.");
    v("level", level, "Which of the level planes is the ground.");
  }
};

/// The ground, where one was found.
struct GroundResult {
  std::optional<Ground> ground;
  std::string reason;         ///< What was found, or why nothing was.
  std::vector<Plane> tables;  ///< Level planes above it on which objects may stand, largest first.
};

/// The plane that things stand on. Level planes are voted by the planes of image blocks and tried in the
/// order of their evidence; the first that explains enough pixels is the ground, refined on all of them with
/// weights of the noise model. `up_W`: unit vector against gravity when it is known; else the image's own up
/// is a weak hint, under which walls in view of a camera that looks level or down never pass. Deterministic.
[[nodiscard]] GroundResult find_ground(const OrganisedCloud& cloud, const std::vector<BlockPlane>& blocks,
                                       const std::optional<Vec3>& up_W, const NoiseModel& noise,
                                       const GroundConfig& config);

/// A table top of GroundResult::tables, refined on its pixels as the ground is.
[[nodiscard]] Ground refine_table(const Plane& table, const OrganisedCloud& cloud, const NoiseModel& noise,
                                  const GroundConfig& config);

}  // namespace colift::perception
