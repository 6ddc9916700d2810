#pragma once

#include <cstdint>
#include <vector>

#include "hal/config/range.hpp"
#include "perception/organised_cloud.hpp"
#include "perception/scene.hpp"
#include "perception/target/regions/components.hpp"

namespace colift::perception {

/// Which pixels that an object surrounds belong to it.
struct EnclosedConfig {
  double footprint_inset_m = 0.01;
  double max_below_ground_m = 0.01;

  template <class Visitor>
  void visit(Visitor& v) {
    v("footprint_inset_m", footprint_inset_m, hal::Range{0, 0.5},
      "Distance that enclosed pixels keep from the rim of the object's footprint: outside of it is the floor "
      "(m).");
    v("max_below_ground_m", max_below_ground_m, hal::Range{0, 0.5},
      "Max depth below the ground of an enclosed pixel, by its noise (m).");
  }
};

/// Pixels that an object surrounds in the image and that lie over its footprint: the bottom of an open box, a
/// seat behind the slats of a back rest. They belong to it although no path of equal depth leads there.
/// `pixels`: ascending, the object's own. `barred`: per pixel, not 0 where something else is known to be.
/// Pixels with fewer than `min_neighbours` of the eight around them on one surface by `jump` are left out:
/// between an edge and what lies behind it a pixel shows a depth at which there is nothing. The result is
/// ascending.
[[nodiscard]] std::vector<std::uint32_t> enclosed_pixels(const OrganisedCloud& cloud, const Ground& ground,
                                                         const std::vector<std::uint32_t>& pixels,
                                                         const std::vector<std::uint8_t>& barred,
                                                         const DepthJump& jump, int min_neighbours,
                                                         const EnclosedConfig& config = {});

}  // namespace colift::perception
