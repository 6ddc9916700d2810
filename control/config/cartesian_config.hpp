#pragma once

#include "hal/config/range.hpp"

namespace colift::control {

/// Impedance of the palm while it carries, in W (z up). SI units.
struct CartesianConfig {
  double up_n_m = 4000.0;
  double side_n_m = 1000.0;
  double tilt_nm_rad = 500.0;
  double turn_nm_rad = 100.0;
  double null_nm_rad = 100.0;
  double blend_s = 0.5;

  template <class Visitor>
  void visit(Visitor& v) {
    v("up_n_m", up_n_m, hal::Range{100, 5000}, "Stiffness along gravity (N/m).");
    v("side_n_m", side_n_m, hal::Range{0, 5000}, "Stiffness in each horizontal direction (N/m).");
    v("tilt_nm_rad", tilt_nm_rad, hal::Range{0, 1000}, "Stiffness about each horizontal axis (N m/rad).");
    v("turn_nm_rad", turn_nm_rad, hal::Range{0, 1000}, "Stiffness about the vertical (N m/rad).");
    v("null_nm_rad", null_nm_rad, hal::Range{0, 500},
      "Stiffness of the arm's posture in the null space of the palm's motion (N m/rad).");
    v("blend_s", blend_s, hal::Range{0.02, 5}, "Time in which one impedance turns into the other (s).");
  }
};

}  // namespace colift::control
