#pragma once

#include <string>

#include "hal/config/range.hpp"

namespace colift::control {

/// The bounds of a lift that are said before it. Each is a scale that the decision computes, times a factor
/// that lifts of the calibration showed to hold in 95 % of them (split conformal prediction: Vovk, Gammerman,
/// Shafer, 2005; Lei et al., JASA 2018). `colift experiment certificate` makes these figures for a rig.
struct CertificateConfig {
  std::string on_breach;
  double mass_sigma;
  double share_below, share_above;
  double load_below, load_above;
  double lead_m, turning, tilt_factor;
  double slip_base_m, slip_factor;

  /// Of the simulated rig: control/config/certificate_config.cpp says by which command.
  CertificateConfig();

  template <class Visitor>
  void visit(Visitor& v) {
    v("on_breach", on_breach, hal::Choices{"report", "test", "refuse"},
      "Where a bound is beyond its limit: say so, make a test lift first, or do not lift.");
    v("mass_sigma", mass_sigma, hal::Range{0.0, 1.0},
      "Relative standard deviation of a mass that is told (decision.known_mass_kg) or was measured.");
    v("share_below", share_below, hal::Range{0.0, 20.0},
      "How far below the predicted share the interval reaches, in its standard deviations.");
    v("share_above", share_above, hal::Range{0.0, 20.0}, "The same above.");
    v("load_below", load_below, hal::Range{0.0, 20.0},
      "How far below the predicted load of the hand its interval reaches, in its standard deviations.");
    v("load_above", load_above, hal::Range{0.0, 20.0}, "The same above.");
    v("lead_m", lead_m, hal::kPositive,
      "How far one hand is ahead of the other while both raise the object (m); over their distance it is a "
      "tilt.");
    v("turning", turning, hal::Range{0.0, 10.0},
      "How much of the angle counts by which the torque of the centre of gravity about the line of the hands "
      "would turn grips of test_lift.belief.grip_nm_rad.");
    v("tilt_factor", tilt_factor, hal::Range{0.0, 100.0}, "Bound of the tilt over the sum of these two.");
    v("slip_base_m", slip_base_m, hal::kPositive,
      "Slip in the hand that a lift may have without load (m), before slip_factor.");
    v("slip_factor", slip_factor, hal::Range{0.0, 1000.0},
      "Bound of the slip over its scale: slip_base_m times 1 and the load over what friction holds.");
  }
};

}  // namespace colift::control
