#pragma once

#include <cstdint>
#include <vector>

#include "hal/config/range.hpp"
#include "perception/noise_model.hpp"
#include "perception/organised_cloud.hpp"
#include "perception/scene.hpp"

namespace colift::perception {

/// Which small regions in the target's box go with it.
struct SliverConfig {
  double box_margin_m = 0.01;
  double box_margin_sigma = 3.0;
  double min_height_m = 0.015;
  double min_height_sigma = 4.0;
  double max_area_m2 = 0.005;
  double min_in_box_fraction = 0.9;
  double jump_base_m = 0.012;
  double jump_sigma = 3.0;
  double jump_steps = 1.5;
  int window_margin_px = 12;

  template <class Visitor>
  void visit(Visitor& v) {
    v("box_margin_m", box_margin_m, hal::Range{0, 0.5},
      "Margin around the target's box in which slivers lie: the box leaves out stray pixels (m).");
    v("box_margin_sigma", box_margin_sigma, hal::Range{0, 20},
      "The same, in standard deviations of the depth noise.");
    v("min_height_m", min_height_m, hal::Range{0, 1}, "Min height of a sliver's pixels over the ground (m).");
    v("min_height_sigma", min_height_sigma, hal::Range{0, 20},
      "The same, in standard deviations of the depth noise.");
    v("max_area_m2", max_area_m2, hal::kPositive,
      "Max visible area of a sliver (m^2); the default is that of the smallest target.");
    v("min_in_box_fraction", min_in_box_fraction, hal::kFraction,
      "Min fraction of a sliver's pixels in the target's box; some fly off towards the background.");
    v("jump_base_m", jump_base_m, hal::kNotNegative,
      "Max depth difference of neighbouring pixels of one sliver, fixed part (m).");
    v("jump_sigma", jump_sigma, hal::kNotNegative, "The same, in standard deviations of the depth noise.");
    v("jump_steps", jump_steps, hal::kNotNegative, "The same, in quantisation steps.");
    v("window_margin_px", window_margin_px, hal::Range{1, 1000},
      "Pixels around the target in the image; a region that leaves this window is no sliver (px).");
  }
};

/// Pixels, ascending, that stand in the target's box without being its own, in regions too small to be a
/// thing: slivers of a post that the rest of it half hides, what lies between an edge and its background, a
/// cup on the seat. No surface can rest on them, but they go where the target goes. Regions of which a part
/// stands outside of the box are something else. Needs Target::pixels; without them there are none.
[[nodiscard]] std::vector<std::uint32_t> find_slivers(const OrganisedCloud& cloud, const Target& target,
                                                      const Ground& ground, const NoiseModel& noise,
                                                      const SliverConfig& config = {});

}  // namespace colift::perception
