#pragma once

#include <optional>
#include <vector>

#include "hal/config/range.hpp"
#include "perception/ground/block_planes.hpp"
#include "perception/ground/plane_vote.hpp"
#include "perception/noise_model.hpp"
#include "perception/scene.hpp"

namespace colift::perception {

/// What speaks for a plane being the ground.
struct LevelPlaneConfig {
  double max_below_fraction = 0.15;
  double never_below_fraction = 0.35;
  double min_area_m2 = 0.1;
  double min_area_fraction = 0.03;
  double below_margin_m = 0.03;
  double below_margin_sine = 0.03;
  double upright_sine = 0.17;
  double level_cosine = 0.985;
  double tilt_scale_deg = 50.0;

  template <class Visitor>
  void visit(Visitor& v) {
    v("max_below_fraction", max_below_fraction, hal::kFraction,
      "Fraction of the flat area in view below a plane at which its evidence ends; nothing lies below a "
      "floor but mirror images.");
    v("never_below_fraction", never_below_fraction, hal::kFraction,
      "Max fraction of the flat area in view that lies below the ground: shoulders and shelves are no "
      "ground.");
    v("min_area_m2", min_area_m2, hal::kNotNegative, "Min area of the ground in view (m^2).");
    v("min_area_fraction", min_area_fraction, hal::kFraction,
      "The same, as a fraction of the flat area in view.");
    v("below_margin_m", below_margin_m, hal::kNotNegative,
      "Min depth below a plane of what counts as below it (m).");
    v("below_margin_sine", below_margin_sine, hal::kFraction,
      "The same, as a fraction of the distance from the camera: a plane's tilt is not known exactly.");
    v("upright_sine", upright_sine, hal::kFraction,
      "Max sine of the lean of a surface that counts as upright (0.17: 10 degrees).");
    v("level_cosine", level_cosine, hal::kFraction,
      "Min cosine of the tilt of a surface that counts as level (0.985: 10 degrees).");
    v("tilt_scale_deg", tilt_scale_deg, hal::Range{1, 1000},
      "Tilt against the image's up at which a plane's evidence falls to 37 %, when gravity is unknown "
      "(deg).");
  }
};

/// A plane that may be the ground, with what speaks for it.
struct LevelPlane {
  VotedPlane voted;
  double below_fraction = 0.0;       ///< Part of the flat area in view that lies below it.
  double consistent_fraction = 0.0;  ///< Part of the flat area in view that is upright or level beside it.
  double tilt_deg = 0.0;             ///< Against the up that was given.
  double evidence = 0.0;             ///< Larger is better; 0 is none.
};

/// Voted planes in the order of the evidence that they are the ground: a large part of the area in view lies
/// on it, nothing below it, the other surfaces are upright or level beside it as walls and tables are, and it
/// is not far from the image's own level when gravity is unknown. `up_W`: a unit vector; `up_known`: it is
/// against gravity, not only the image's own up. Planes with more below them than the config allows come
/// last, with little evidence left: a table top where nearly no floor is in view.
[[nodiscard]] std::vector<LevelPlane> order_level_planes(std::vector<VotedPlane> planes,
                                                         const std::vector<BlockPlane>& blocks,
                                                         const Vec3& eye_W, const Vec3& up_W, bool up_known,
                                                         const LevelPlaneConfig& config);

}  // namespace colift::perception
