#pragma once

#include "hal/config/range.hpp"

namespace colift::control {

/// How the load at the palm is estimated from external joint torques, and what follows from it.
struct LoadConfig {
  double filter_s = 0.05;
  double known_mass_sigma = 0.005;
  double moment_sigma = 0.015;
  double partner_torque_nm = 0.3;

  template <class Visitor>
  void visit(Visitor& v) {
    v("filter_s", filter_s, hal::Range{0, 2}, "Time constant of the force estimate (s).");
    v("known_mass_sigma", known_mass_sigma, hal::Range{0, 0.5},
      "Standard deviation of a known mass, as a fraction of it.");
    v("moment_sigma", moment_sigma, hal::kFraction,
      "Standard deviation of the measured moment, as a fraction of it.");
    v("partner_torque_nm", partner_torque_nm, hal::Range{0, 10},
      "Standard deviation of the torque with which the partner's hand resists a turn of the object (N m).");
  }
};

}  // namespace colift::control
