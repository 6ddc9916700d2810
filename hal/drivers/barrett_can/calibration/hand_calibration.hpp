#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "hal/config/range.hpp"
#include "hal/types/result.hpp"

namespace colift::hal {

/// What was measured of one puck's strain gauge and motor.
struct PuckScale {
  int serial = 0;
  std::string finger;  ///< Where it was then.
  std::string date;
  double strain_scale = 1.0;         ///< True torque over that of the maker's curve.
  double strain_residual_nm = 0.0;   ///< Root mean square over its points.
  int strain_points = 0;             ///< 0: not measured; the scale is 1 then.
  double torque_units_per_nm = 0.0;  ///< Of the motor, at the fingertip; 0: not measured.
  int torque_points = 0;

  template <class Visitor>
  void visit(Visitor& v) {
    v("serial", serial, Range{1, 2147483647}, "SN of the puck.", Presence::Required);
    v("finger", finger, "F1, F2 or F3: where it was measured.");
    v("date", date, "When.");
    v("strain_scale", strain_scale, Range{0.2, 5}, "True torque over that of the maker's curve.");
    v("strain_residual_nm", strain_residual_nm, kNotNegative, "Root mean square over its points (N m).");
    v("strain_points", strain_points, Range{0, 1000}, "Known torques that it rests on; 0: not measured.");
    v("torque_units_per_nm", torque_units_per_nm, Range{0, 50000},
      "Units of the motor for 1 N m at the fingertip; 0: not measured.");
    v("torque_points", torque_points, Range{0, 1000}, "Torques that it rests on.");
  }
};

/// What `colift hal hand calibrate` writes and the driver reads (schema colift.hand_calibration/1): scales
/// that belong to a puck, not to a place in a hand.
struct HandCalibration {
  std::string schema = "colift.hand_calibration/1";
  std::vector<PuckScale> pucks;

  template <class Visitor>
  void visit(Visitor& v) {
    v("schema", schema, Choices{"colift.hand_calibration/1"}, "What this file is.", Presence::Required);
    v("pucks", pucks, "Each puck that was measured, by its serial number.");
  }
  /// nullptr: not measured.
  [[nodiscard]] const PuckScale* of(std::int32_t serial) const;
  /// In the place of what was measured of that puck before; what the new one has not measured stays.
  void take(const PuckScale& scale);
};

/// Errors: BadConfig with FILE:LINE:COLUMN (a serial number twice, too), NotFound (no such file).
[[nodiscard]] Result<HandCalibration> parse_hand_calibration(const std::string& yaml,
                                                             const std::string& name);
[[nodiscard]] Result<HandCalibration> load_hand_calibration(const std::filesystem::path& file);
[[nodiscard]] std::string text_of(const HandCalibration& calibration);

/// Two torques that belong together (N m, or units of a motor).
struct ScalePoint {
  double is = 0.0, shown = 0.0;
};
struct ScaleFit {
  double scale = 1.0;     ///< is = scale * shown, least squares through 0.
  double residual = 0.0;  ///< Root mean square, in the unit of `is`.
};
/// Errors: BadInput (fewer than two points that are not 0, a number that is none, all shown as 0, or points
/// that lie no line through 0: residual above a tenth of the largest).
[[nodiscard]] Result<ScaleFit> fit_scale(std::span<const ScalePoint> points);

}  // namespace colift::hal
