#pragma once

#include "hal/config/range.hpp"

namespace colift::control {

/// When a collision map cannot be the room that the camera observed.
struct MapCheckConfig {
  double max_occupied_fraction = 0.5;
  double min_kept_fraction = 0.3;
  int min_points = 200;
  double max_distance_m = 3.0;

  template <class Visitor>
  void visit(Visitor& v) {
    v("max_occupied_fraction", max_occupied_fraction, hal::kFraction,
      "Max fraction of the known cells that is occupied; a room with a camera in it has a few percent.");
    v("min_kept_fraction", min_kept_fraction, hal::kFraction,
      "Min fraction of the observed points in the mapped space that the map holds.");
    v("min_points", min_points, hal::Range{1, 100000}, "With fewer points that is not judged.");
    v("max_distance_m", max_distance_m, hal::Range{0.1, 20},
      "Farther points are not counted: they may lie beyond what is entered (m).");
  }
};

/// When a depth image has too many holes to be relied on.
struct ImageCheckConfig {
  int margin_px = 32;
  double max_hole_fraction = 0.42;

  template <class Visitor>
  void visit(Visitor& v) {
    v("margin_px", margin_px, hal::Range{0, 640}, "Pixels around the target that are judged with it.");
    v("max_hole_fraction", max_hole_fraction, hal::kFraction,
      "Max fraction of pixels without depth on and around the target: it is up to 0.34 on real recordings, "
      "and 0.45 and more where half of the pixels are gone.");
  }
};

}  // namespace colift::control
