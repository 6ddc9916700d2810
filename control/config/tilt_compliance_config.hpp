#pragma once

#include "hal/config/range.hpp"

namespace colift::control {

/// How the palm that carries gives way to what tilts the object between the hands.
struct TiltComplianceConfig {
  double speed_rad_s_nm = 0.005;
  double max_deg = 5.0;

  template <class Visitor>
  void visit(Visitor& v) {
    v("speed_rad_s_nm", speed_rad_s_nm, hal::Range{0, 0.1},
      "Angular speed of the palm about the horizontal axis across the line of the hands, per moment about "
      "it; 0: none (rad/s per N m).");
    v("max_deg", max_deg, hal::Range{0, 45}, "Max angle that the palm turns by (deg).");
  }
};

}  // namespace colift::control
