#pragma once

#include <cstdint>
#include <vector>

#include "hal/config/range.hpp"
#include "perception/ground/image_border.hpp"
#include "perception/noise_model.hpp"
#include "perception/organised_cloud.hpp"
#include "perception/scene.hpp"
#include "perception/target/regions/components.hpp"
#include "perception/target/regions/fragments.hpp"

namespace colift::perception {

/// How the outline of an object is read.
struct OutlineConfig {
  int skip_px = 5;
  int reach_px = 60;
  double ground_height_m = 0.03;

  template <class Visitor>
  void visit(Visitor& v) {
    v("skip_px", skip_px, hal::Range{1, 100},
      "Distance from the outline at which the surroundings are looked at (px): sensors smear edges.");
    v("reach_px", reach_px, hal::Range{1, 1000},
      "Max distance over which a gap without depth beside the outline is crossed (px).");
    v("ground_height_m", ground_height_m, hal::Range{0, 1},
      "Max height over the ground of what counts as ground beside the object (m).");
  }
};

/// What lies beyond an object's outline in the image: parts of its length, that together are 1. An object
/// that stands free has the ground and farther things around it; a piece of a wall, of stairs or of a
/// cupboard goes on at its own depth.
struct Outline {
  double farther = 0.0, ground = 0.0;
  double same = 0.0;     ///< Something at the same depth: the object may go on, or touch it.
  double nearer = 0.0;   ///< Something in front hides where the object ends.
  double rim = 0.0;      ///< The view ends.
  double unknown = 0.0;  ///< No depth within reach.

  [[nodiscard]] double free() const { return farther + ground; }
};

/// Reads the outline of `object` at the ends of its pixels' rows and columns. `label`: the region of every
/// pixel, Components::labels().
[[nodiscard]] Outline read_outline(const OrganisedCloud& cloud, const Components& components,
                                   const std::vector<std::int32_t>& label, const Fragment& object,
                                   const Ground& ground, const ImageBorder& border, const DepthJump& jump,
                                   const OutlineConfig& config = {});

}  // namespace colift::perception
