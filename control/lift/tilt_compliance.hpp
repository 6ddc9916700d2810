#pragma once

#include "control/config/tilt_compliance_config.hpp"
#include "hal/types/geometry.hpp"

namespace colift::control {

/// The line between the two hands that carry an object.
struct HandLine {
  hal::Vec3 pivot_H = hal::Vec3::Zero();  ///< Where the load acts on the hand, in the palm frame H (m).
  hal::Vec3 along_W = hal::Vec3::Zero();  ///< Horizontal, length 1, towards the partner; zero: not known.
};

/// Compliance of the palm about the horizontal axis across the line of the hands, through the point where the
/// load acts: the palm turns at a speed proportional to the moment about it (admittance, Hogan 1985), so that
/// this moment fades. A palm that is held stiff there bears a moment whenever the partner holds his end a
/// little higher or lower, and shifts load between the hands by it; without it the shares are those of the
/// lever rule. Allocation-free.
class TiltCompliance {
 public:
  explicit TiltCompliance(const TiltComplianceConfig& config) : config_(config) {}

  void start(const HandLine& line);
  /// One cycle of `dt_s`: `wrench_W` of the environment on the hand about the palm, `X_WH` the palm's pose.
  void update(double dt_s, const hal::Wrench& wrench_W, const hal::Pose& X_WH);
  /// The motion (W) of what hangs at the hand, whose pivot is at `pivot_W`, from its pose with a stiff palm.
  [[nodiscard]] hal::Pose motion(const hal::Vec3& pivot_W) const;

  [[nodiscard]] double turned_rad() const { return turned_rad_; }

 private:
  TiltComplianceConfig config_;
  HandLine line_;
  hal::Vec3 across_W_ = hal::Vec3::Zero();
  double turned_rad_ = 0.0;
};

}  // namespace colift::control
