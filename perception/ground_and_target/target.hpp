#pragma once

#include <optional>
#include <string>
#include <vector>

#include "hal/config/range.hpp"
#include "perception/footprint.hpp"
#include "perception/ground_and_target/block_planes.hpp"
#include "perception/ground_and_target/fragments.hpp"
#include "perception/ground_and_target/walls.hpp"
#include "perception/noise_model.hpp"
#include "perception/organised_cloud.hpp"
#include "perception/scene.hpp"

namespace colift::perception {

/// What counts as an object to be carried.
struct TargetConfig {
  double clearance_m = 0.006;
  double clearance_sigma = 3.0;
  double max_range_m = 4.5;
  double max_height_m = 1.3;
  double min_thickness_m = 0.025;
  double min_area_m2 = 0.005;
  double max_cut = 0.5;
  double jump_base_m = 0.012;
  double jump_sigma = 3.0;
  double jump_steps = 1.5;
  int min_neighbours = 3;
  FragmentConfig fragments;
  WallConfig walls;

  template <class Visitor>
  void visit(Visitor& v) {
    v("clearance_m", clearance_m, hal::kNotNegative,
      "What lies lower over the ground, beside the noise, is ground.");
    v("clearance_sigma", clearance_sigma, hal::kNotNegative, "Noise of the ground, in standard deviations.");
    v("max_range_m", max_range_m, hal::kPositive, "Farther objects are not looked at.");
    v("max_height_m", max_height_m, hal::kPositive,
      "Taller things are persons or furniture that is not carried.");
    v("min_thickness_m", min_thickness_m, hal::kNotNegative, "Flatter things are unevenness of the ground.");
    v("min_area_m2", min_area_m2, hal::kPositive, "Smallest visible area of a target.");
    v("max_cut", max_cut, hal::kFraction,
      "An object of which more than this part of a side leaves the view at the left, right or bottom is not "
      "free-standing.");
    v("jump_base_m", jump_base_m, hal::kNotNegative,
      "Depth difference of neighbouring pixels on one surface, fixed part.");
    v("jump_sigma", jump_sigma, hal::kNotNegative, "The same, in standard deviations of the depth noise.");
    v("jump_steps", jump_steps, hal::kNotNegative, "The same, in quantisation steps.");
    v("min_neighbours", min_neighbours, hal::Range{0, 8},
      "A pixel with fewer neighbours at its depth is a flying pixel.");
    v("fragments", fragments, "How image regions are joined to objects.");
    v("walls", walls, "What counts as a wall.");
  }
};

/// Something above the ground that was not chosen, and why.
struct RejectedObject {
  enum class Kind { Small, Flat, Far, Person, Cut, Wall, Lesser };
  Kind kind = Kind::Small;
  Vec3 center = Vec3::Zero();  ///< Middle of its box in W (m).
  std::size_t pixels = 0;
  std::string because;
};

/// The target, where there is one, and the objects that were refused.
struct TargetResult {
  std::optional<Target> target;  ///< Without surfaces and completion: shape equals obb, cog its centre.
  std::vector<RejectedObject> rejected;  ///< Largest first.
  std::string because;
};

/// The object to be carried: the largest free-standing one on the ground, or the one nearest to `at_W`.
/// Objects are connected regions of the image above the ground, cut apart at depth jumps that the noise does
/// not explain, cleaned of flying pixels, freed from walls, and joined over holes and hidden parts.
[[nodiscard]] TargetResult find_target(const OrganisedCloud& cloud, const std::vector<BlockPlane>& blocks,
                                       const Ground& ground, const NoiseModel& noise,
                                       const TargetConfig& config,
                                       const std::optional<Vec3>& at_W = std::nullopt);

}  // namespace colift::perception
