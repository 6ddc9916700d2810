#pragma once

#include <optional>

#include "planner/grasp/grasp_decision.hpp"
#include "planner/grasp/robust_choice.hpp"
#include "planner/grasp_candidate.hpp"
#include "planner/hand/hand_model.hpp"

namespace colift::control {

/// What a lift by one grasp is expected to be, and the scale on which each expectation errs. To first order,
/// from the covariances of the centre of gravity and of the partner's grasp.
struct LiftForecast {
  double share = 0.0;        ///< Of the robot, by the lever rule.
  double share_sigma = 0.0;  ///< Standard deviation.
  double span_m = 0.0;       ///< Horizontal distance of both hands.
  bool mass_known = false;
  double weight_n = 0.0;  ///< Of the object; of DecisionConfig::usual_mass_kg where the mass is not known.
  /// Torque of the weight about the line between both hands: lever and its standard deviation, root of the
  /// sum of squares (N m). Grips that turn let it tilt the object.
  double turning_nm = 0.0;
  double load_over_hold = 0.0;  ///< Load of the hand over what its friction holds; 1: it slips.
};

/// `share`: of the decision. `mass_kg`: unset where it is not known. `robot_W`: where the load hangs in its
/// hand (planner::load_point).
[[nodiscard]] LiftForecast forecast_lift(const planner::UncertainScene& scene,
                                         const planner::GraspCandidate& grasp, double share,
                                         const planner::HandModel& hand,
                                         const planner::DecisionConfig& config,
                                         std::optional<double> mass_kg);

}  // namespace colift::control
