#pragma once

#include <cmath>
#include <optional>
#include <string>
#include <vector>

#include "control/session/decide.hpp"
#include "control/task/task_context.hpp"

namespace colift::control {

/// Which grasp the robot takes: judges reach, decides, and remembers what has been tried without success.
class GraspSelector {
 public:
  explicit GraspSelector(TaskContext& context) : c_(context) {}

  /// A scene was analysed: judges the reach of its candidates, from which every decision starts.
  void set_scene();
  /// A new decision begins: forgets which grasps had no path in the last one.
  void begin_decision();
  /// Decides for the partner's grasp; the record has the decision then. False when no grasp is feasible or
  /// the partner's grasp is not known; attempts.failure says why.
  [[nodiscard]] bool choose();

  /// The chosen grasp has no path: left out for the rest of this decision.
  void refuse_path(const std::string& why);
  /// A grip at the chosen grasp failed: none is tried near it again in this job. Where the fingers were
  /// stopped by something else than the face that was seen, none from this side that reaches as deep.
  void refuse_grip(const std::string& why);
  /// On the way to the chosen grasp the hand met something that the camera does not see: none is tried near
  /// it from the same side again in this job.
  void refuse_approach(const std::string& why);
  /// A test lift at the chosen grasp hangs still, if not level: kept if it is the most level one so far.
  void keep_bearable(double share, double tilt_rad);
  void forget_bearable();
  /// The bearable grasp was chosen because there is no better one.
  [[nodiscard]] bool accepts_bearable() const { return accepts_bearable_; }

  /// The object was put down elsewhere: places on it move along (W).
  void object_moved(const hal::Pose& X_Wnow_Wthen);

  /// Candidates of the scene, with reach.
  [[nodiscard]] const std::vector<planner::GraspCandidate>& judged() const { return judged_; }

 private:
  /// Sets to Unreachable what the arm does not reach; where it does not get there straight, but at an angle
  /// to the face, the candidate becomes that one.
  void judge_reach(std::vector<planner::GraspCandidate>& candidates);
  /// JobPolicies::choice. False where it names a candidate that is not feasible: nothing is chosen then.
  [[nodiscard]] bool take_own_choice();
  void test_beyond_limits();
  /// Why a load that a test lift made known is not lifted.
  [[nodiscard]] std::optional<std::string> too_heavy() const;
  /// decide_for(), with whether anybody saw the partner's hand.
  [[nodiscard]] hal::Result<Outcome> decide(const perception::PartnerGrasp& partner, const Config& config,
                                            const Judge& reach) const;
  /// Of what covers a body that nobody sees the rim alone is grasped: grasps as those that were refused with
  /// a depth, which reach less deep.
  void add_shallower(std::vector<planner::GraspCandidate>& candidates);
  [[nodiscard]] bool something_between() const;
  void apply_refusals(std::vector<planner::GraspCandidate>& candidates) const;
  [[nodiscard]] bool choose_level(const perception::PartnerGrasp& partner, const Judge& reach);
  /// Of the object, where somebody knows it or a test lift measured it.
  /// Brings the record's share up to a grasp that was not chosen by the decision, but after test lifts; false
  /// where that grasp is too far from the wanted share.
  [[nodiscard]] bool renew_share(const perception::PartnerGrasp& partner, const TestLift& known);

  struct FailedGrasp {
    hal::Vec3 position;
    std::optional<hal::Vec3> approach;  ///< Of no other side; unset: of none.
    double radius_m;
    planner::Verdict verdict;
    std::string why;
    double from_depth_m = -INFINITY;  ///< Of none that reaches less deep behind the face.

    [[nodiscard]] bool covers(const planner::GraspCandidate& c) const;
  };
  struct Bearable {
    planner::GraspCandidate grasp;
    double share = 0.0, tilt_rad = 0.0;
  };

  TaskContext& c_;
  std::vector<planner::GraspCandidate> judged_;
  std::vector<planner::GraspCandidate> without_path_;  ///< In this decision.
  std::vector<FailedGrasp> failed_;
  std::optional<Bearable> bearable_;
  bool accepts_bearable_ = false;
};

}  // namespace colift::control
