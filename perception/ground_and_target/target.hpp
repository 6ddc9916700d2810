#pragma once

#include <optional>
#include <string>
#include <vector>

#include "hal/config/range.hpp"
#include "perception/footprint.hpp"
#include "perception/ground_and_target/block_planes.hpp"
#include "perception/ground_and_target/enclosed_pixels.hpp"
#include "perception/ground_and_target/fragments.hpp"
#include "perception/ground_and_target/slivers.hpp"
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
  int min_pixels = 300;
  double clearance_rms = 2.5;
  double max_person_top_cut = 0.25;
  double top_cut_weight = 0.4;
  FragmentConfig fragments;
  WallConfig walls;
  EnclosedConfig enclosed;
  SliverConfig slivers;
  BoxTrim box;

  template <class Visitor>
  void visit(Visitor& v) {
    v("clearance_m", clearance_m, hal::kNotNegative,
      "Max height of the ground's pixels, beside the noise (m).");
    v("clearance_sigma", clearance_sigma, hal::kNotNegative,
      "The same, in standard deviations of the depth noise.");
    v("max_range_m", max_range_m, hal::kPositive, "Max distance of a target from the camera (m).");
    v("max_height_m", max_height_m, hal::kPositive,
      "Max height of a target (m); taller things are persons or furniture that is not carried.");
    v("min_thickness_m", min_thickness_m, hal::kNotNegative,
      "Min height of a target over the ground (m); flatter things are unevenness of the ground.");
    v("min_area_m2", min_area_m2, hal::kPositive, "Min visible area of a target (m^2).");
    v("max_cut", max_cut, hal::kFraction,
      "Max fraction of a target's side that the left, right or bottom of the view cuts off.");
    v("jump_base_m", jump_base_m, hal::kNotNegative,
      "Max depth difference of neighbouring pixels on one surface, fixed part (m).");
    v("jump_sigma", jump_sigma, hal::kNotNegative, "The same, in standard deviations of the depth noise.");
    v("jump_steps", jump_steps, hal::kNotNegative, "The same, in quantisation steps.");
    v("min_neighbours", min_neighbours, hal::Range{0, 8},
      "Min number of neighbours at its own depth of a pixel that is kept; others are flying pixels.");
    v("min_pixels", min_pixels, hal::Range{1, 1e6}, "Min number of pixels of a target.");
    v("clearance_rms", clearance_rms, hal::Range{0, 100},
      "Max height of the ground's pixels on an uneven floor, in root mean square residuals of the ground.");
    v("max_person_top_cut", max_person_top_cut, hal::kFraction,
      "An object taller than wide, of whose upper side the view cuts off more than this fraction, may be a "
      "person.");
    v("top_cut_weight", top_cut_weight, hal::kFraction,
      "Weight in max_cut of the fraction of the upper side that the view cuts off: it hides height, not "
      "footprint.");
    v("fragments", fragments, "How image regions are joined to objects.");
    v("walls", walls, "What counts as a wall.");
    v("enclosed", enclosed, "Pixels that the object surrounds in the image.");
    v("box", box, "Which stray points the object's box leaves out.");
    v("slivers", slivers, "Small regions that belong to the object without being a surface of it.");
  }
};

/// Something above the ground that was not chosen, and why.
struct RejectedObject {
  enum class Kind { Small, Flat, Far, Person, Cut, Wall, Lesser };
  Kind kind = Kind::Small;
  Vec3 center = Vec3::Zero();  ///< Middle of its box in W (m).
  std::size_t pixels = 0;
  std::string reason;
};

/// The target, where there is one, and the objects that were refused.
struct TargetResult {
  std::optional<Target> target;  ///< Without surfaces and completion: shape equals obb, cog its centre.
  std::vector<RejectedObject> rejected;  ///< Largest first.
  std::string reason;
};

/// The object to be carried: the largest free-standing one on the ground, or the one nearest to `at_W`.
/// Objects are connected regions of the image above the ground, cut apart at depth jumps that the noise does
/// not explain, cleaned of flying pixels, freed from walls, and joined over holes and hidden parts.
[[nodiscard]] TargetResult find_target(const OrganisedCloud& cloud, const std::vector<BlockPlane>& blocks,
                                       const Ground& ground, const NoiseModel& noise,
                                       const TargetConfig& config,
                                       const std::optional<Vec3>& at_W = std::nullopt);

}  // namespace colift::perception
