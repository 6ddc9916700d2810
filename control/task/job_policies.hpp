#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <vector>

#include "control/session/decide.hpp"
#include "control/task/run_record.hpp"

namespace colift::control {

/// How a raised object is carried on.
struct CarryOrder {
  double speed_scale =
      1.0;  ///< Of the palm's planned speed, 0 to 1; people near the arm may slow it further.
  bool lower =
      false;  ///< The hold is over: announced, then lowered. While it is raised this counts for nothing.
};

/// What a program decides in place of CoLift; each may be empty. Called from the thread that called
/// run_job(), between two cycles of the task, so a slow one makes the job late. What they return is checked
/// like CoLift's own.
struct JobPolicies {
  /// The grasp candidates of a scene, in place of CoLift's (which the analysis holds). Each is judged for
  /// collision, stability and reach; around the closed-form optimum none are added.
  std::function<std::vector<planner::GraspCandidate>(const SceneAnalysis&)> grasps;
  /// Where the partner holds the object (W), once he is seen to hold it. One that decide_for() refuses ends
  /// the decision without a grasp.
  std::function<perception::PartnerGrasp(const SceneAnalysis&, const perception::PartnerGrasp& seen)> partner;
  /// Which candidate of a decision is taken, by index. Unset: CoLift's choice. One that is not feasible ends
  /// the decision without a grasp. Not asked after test lifts, which choose for themselves.
  std::function<std::optional<std::size_t>(const SceneAnalysis&, const Outcome&)> choice;
  /// Once for each camera frame while the object is raised and held.
  std::function<CarryOrder(const LiftSample&)> carry;
};

}  // namespace colift::control
