#pragma once

#include <cmath>
#include <cstddef>
#include <string>

namespace colift::control {

/// What became of one camera when the scene was seen.
struct ViewReport {
  bool used = false;            ///< Its frames count.
  bool knows_object = false;    ///< They tell of partner and object too, not of map and bodies alone.
  double agreement_m = NAN;     ///< Median distance of what it and the first camera show at rest, corrected.
  double unseen_without = NAN;  ///< PerceptionSession::unseen() without it; NaN with one camera.
  std::string reason;           ///< One sentence with figures.
};

/// A camera that was pushed since the scene was seen.
struct PushedCamera {
  std::size_t camera = 0;
  std::string reason;  ///< One sentence with figures.
};

}  // namespace colift::control
