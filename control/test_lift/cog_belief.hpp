#pragma once

#include <optional>
#include <span>
#include <vector>

#include "control/config/test_lift_config.hpp"
#include "hal/types/geometry.hpp"
#include "hal/types/result.hpp"

namespace colift::control {

/// The object as seen before it is lifted. Frame W, z up.
struct CarriedObject {
  hal::Vec3 cog = hal::Vec3::Zero();  ///< Of the shape.
  Eigen::Matrix3d cog_covariance = Eigen::Matrix3d::Zero();
  std::vector<hal::Vec3> feet;  ///< Where it stands: corners of its base, in order around it.
  std::optional<double> known_mass_kg = {};
};

/// One test lift: means over the time at its top. Frame W.
struct MeasuredLift {
  hal::Wrench measured;  ///< Of the object on the hand, about `palm` (LoadEstimator::wrench_W).
  hal::Vec3 palm = hal::Vec3::Zero();
  hal::Vec3 partner = hal::Vec3::Zero();  ///< Where the partner held it meanwhile.
  hal::Vec3 grasp = hal::Vec3::Zero();    ///< Where the load hangs in the hand.
  /// What the camera saw: moves a point of the object from where it stood to where it was at the top.
  hal::Pose X_WTnow_WTref = hal::Pose::Identity();
  double drift_rad_s = 0.0;  ///< How fast it still turned at the top: Hanging::turn_rad over time.
  double share_predicted = 0.5;
};

/// Where the centre of gravity may be, how heavy the object is then, and how stiffly hands hold it.
struct CogBelief {
  /// One hypothesis: where the centre of gravity is and what the object weighs then (m, kg).
  struct Case {
    Eigen::Vector2d cog = Eigen::Vector2d::Zero();  ///< Level part, W.
    double mass_kg = 0.0;
    double weight = 0.0;  ///< All weights add up to 1.
  };
  std::vector<Case> cases;
  double grip_nm_rad = 0.0;

  [[nodiscard]] Eigen::Vector2d mean() const;
  [[nodiscard]] Eigen::Matrix2d covariance() const;
  [[nodiscard]] double mass_kg() const;  ///< Geometric mean: what is known of it is a product.
};

/// How the object hangs or stands, from what the camera saw.
struct Hanging {
  double turn_rad = 0.0;    ///< About the line from the partner's hand to the robot's, right-handed.
  double tilt_rad = 0.0;    ///< Of its up axis, in any direction.
  double min_rise_m = 0.0;  ///< Of the foot that has risen least.
};
[[nodiscard]] Hanging hanging(const CarriedObject& object, const hal::Vec3& partner, const hal::Vec3& grasp,
                              const hal::Pose& X_WTnow_WTref);

/// Level part of m (c - p1) as if nothing but both hands held the object: torques about the partner's grasp
/// p1 balance without his force (kg m).
[[nodiscard]] Eigen::Vector2d measured_moment(const MeasuredLift& test);

/// Weighs the places c of the centre of gravity over the object's base: a normal prior about that of its
/// shape, and what test lifts say.
///
/// One that hangs in the air: m (c - p1) = q, what the arm feels. The *direction* from the partner is known;
/// mass and distance are one number, so that every distance has its own mass.
/// One of which a foot stands at f: m (c - p1) = q + n (f - p1) with an unknown n >= 0. So the centre of
/// gravity lies between the felt direction and that of the foot, however little is felt; every place has one
/// mass and one n that fit. What was felt about the line between the hands, against the turn that was seen,
/// is how stiffly hands hold the object. Test lifts at several grasps have to agree on the mass, and their
/// directions enclose the place from both sides; where the partner held it at two places they cross, which
/// tells mass and distance apart. The partner's hand is taken as a point, but for a torque of
/// about `partner_nm`. Errors: NotFound (no place fits, or no test lift says anything),
/// BadInput (fewer than three feet).
[[nodiscard]] hal::Result<CogBelief> weigh_cog(const CarriedObject& object,
                                               std::span<const MeasuredLift> tests,
                                               const CogBeliefConfig& config);

/// The robot's part of the weight by the lever rule (planner::lever_share); NaN for grasps one above the
/// other.
[[nodiscard]] double lever_share(const Eigen::Vector2d& cog, const hal::Vec3& partner,
                                 const hal::Vec3& grasp);

/// Chance that the object turns by less than `max_turn_rad` about the line between both hands if the robot
/// takes it at `grasp`. Over the cases, and over grips that hold more or less stiffly than those that were
/// tried (log-normal, `grip_sigma`).
[[nodiscard]] double chance_level(const CogBelief& belief, const hal::Vec3& partner, const hal::Vec3& grasp,
                                  double max_turn_rad, double grip_sigma);
/// The same for one case, with hands that hold by `grip_nm_rad`.
[[nodiscard]] double chance_level(const CogBelief::Case& one, double grip_nm_rad, const hal::Vec3& partner,
                                  const hal::Vec3& grasp, double max_turn_rad, double grip_sigma);

}  // namespace colift::control
