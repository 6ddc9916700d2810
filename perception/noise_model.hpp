#pragma once

#include "hal/config/range.hpp"

namespace colift::perception {

/// Depth noise of a structured-light camera. Every distance threshold follows it, so that no algorithm
/// hard-codes a sensor. Defaults: measured on planes in single Kinect v1 and Xtion frames (sigma) and the
/// Kinect code table (step).
struct NoiseModel {
  double sigma0_m = 0.0003;          ///< Noise floor (m).
  double sigma2_per_m = 0.0012;      ///< Growth with the square of the distance (1/m).
  double step2_per_m = 1.0 / 345.5;  ///< Quantisation: distance between neighbouring codes is step2 * z^2.

  /// Standard deviation of one depth value at distance z (m).
  [[nodiscard]] double sigma(double z_m) const { return sigma0_m + sigma2_per_m * z_m * z_m; }

  /// Distance between two neighbouring depth codes at distance z (m).
  [[nodiscard]] double step(double z_m) const { return step2_per_m * z_m * z_m; }

  template <class Visitor>
  void visit(Visitor& v) {
    v("sigma0_m", sigma0_m, hal::kNotNegative, "Standard deviation of the depth at zero distance (m).");
    v("sigma2_per_m", sigma2_per_m, hal::kNotNegative,
      "Growth of the depth's standard deviation with distance squared (1/m).");
    v("step2_per_m", step2_per_m, hal::kNotNegative,
      "Depth quantisation step divided by distance squared (1/m).");
  }
};

}  // namespace colift::perception
