#pragma once

#include "hal/config/range.hpp"
#include "perception/scene.hpp"
#include "planner/hand/seen_space.hpp"

namespace colift::planner {

/// When a face below a plate is that of a leg.
struct LegFaceConfig {
  double max_edge_fraction = 0.5;
  double min_free_fraction = 0.5;
  double level_fraction = 0.75;
  double step_m = 0.02;

  template <class Visitor>
  void visit(Visitor& v) {
    v("max_edge_fraction", max_edge_fraction, hal::kFraction,
      "Max fraction of the plate's edge that the face of a leg takes up.");
    v("min_free_fraction", min_free_fraction, hal::kFraction,
      "Min fraction of the places beside a leg through which the camera looked into free space.");
    v("level_fraction", level_fraction, hal::kFraction,
      "Height of these places, as a fraction of the face: below a rim, above where a leg ends.");
    v("step_m", step_m, hal::Range{0.001, 0.5}, "Distance between these places (m).");
  }
};

/// Whether a face that goes down from a plate's edge is that of a leg and not the side of the whole: it takes
/// up a small part of the edge, and the camera looked past it into free space at most of the places beside it
/// where a side as deep would be. Such a face says nothing of how thick the plate is. `face` is perpendicular
/// to `plate` and lies below it.
[[nodiscard]] bool is_leg_face(const perception::Rectangle& face, const perception::Rectangle& plate,
                               const SeenSpace& seen, const LegFaceConfig& config = {});

/// Where a rectangle begins and ends along a unit vector (m).
struct Extent {
  double low, high;

  [[nodiscard]] double length() const { return high - low; }
};
[[nodiscard]] Extent extent_of(const perception::Rectangle& rectangle, const Vec3& direction);

}  // namespace colift::planner
