#pragma once

#include <optional>
#include <span>

#include "control/config/load_config.hpp"
#include "hal/types/geometry.hpp"
#include "hal/types/result.hpp"

namespace colift::control {

/// One frame of an object that hangs between the robot's hand and the partner's. Frame W, z up.
struct CarriedSample {
  hal::Wrench wrench;  ///< Of the object on the robot's hand, about `palm`.
  hal::Vec3 palm = hal::Vec3::Zero();
  /// Moves a point of the object from where the scene shows it to where it is now.
  hal::Pose X_WTnow_WTref = hal::Pose::Identity();
};

/// What was known of the object and the partner before the lift. Frame W, as the scene shows it.
struct KnownBefore {
  hal::Vec3 cog = hal::Vec3::Zero();
  Eigen::Matrix3d cog_covariance = Eigen::Matrix3d::Zero();  ///< What density adds to it included.
  hal::Vec3 partner = hal::Vec3::Zero();
  Eigen::Matrix3d partner_covariance = Eigen::Matrix3d::Zero();
  hal::Vec3 grasp = hal::Vec3::Zero();  ///< Where the load hangs in the robot's hand.
  bool weighed = false;                 ///< `cog` comes from test lifts, not from the shape alone.
  std::optional<double> mass_kg = {};
};

/// A value with its interval of 95 %.
struct Interval {
  double low = 0.0, high = 0.0;
};

/// Where the mass of a LoadEstimate comes from.
enum class MassSource {
  Told,      ///< By `decision.known_mass_kg`: share and centre of gravity are measured.
  TestLift,  ///< From the centre of gravity that test lifts found.
  Shape,     ///< From that of the seen shape.
};
[[nodiscard]] const char* word(MassSource source);

/// Mass, share and centre of gravity of a carried object.
struct LoadEstimate {
  double mass_kg = 0.0, share_robot = 0.0;
  Interval mass_95, share_95;
  hal::Vec3 cog = hal::Vec3::Zero();  ///< W, as the scene shows it.
  double cog_sigma_m = 0.0;           ///< Along the line of the hands.
  MassSource source = MassSource::Shape;
};

/// Balance of moments about the partner's hand, which his force does not enter: the weight's is that of the
/// robot's wrench, so m (c - p) = q, level, is measured whatever he does; his hand is taken as a point but
/// for a torque of about `load.partner_torque_nm`. Along the line of the hands q holds mass and lever in one
/// product: either is known only as well as the other was before. The vertical force F on the object and the
/// mass give the share F / (m g). Means over the samples; 95 % intervals from first-order propagation, of the
/// mass in its logarithm.
/// Errors: BadInput (no sample, not finite, hands at one place), NotFound (not observable: the lever of the
/// weight about the partner's hand, or what is borne, is too small against what is not known of it).
[[nodiscard]] hal::Result<LoadEstimate> balance_load(std::span<const CarriedSample> samples,
                                                     const KnownBefore& known, const LoadConfig& config);

}  // namespace colift::control
