#pragma once

#include <optional>
#include <string>
#include <vector>

#include "planner/motion/collision/collision_scene.hpp"
#include "planner/motion/motion_planner.hpp"
#include "planner/motion/trajectory/joint_path.hpp"

namespace colift::planner {

/// Straight ways of the hand that an arm posture has to get through.
struct ReachQuery {
  hal::Pose X_WH = hal::Pose::Identity();  ///< Palm at the grasp.
  hal::Vec3 up = hal::Vec3::UnitZ();
  double lift_m = 0.05;
};

/// A posture that gets to the grasp and through the lift.
struct GraspPosture {
  Reach reach;
  JointPath approach;  ///< Pre-grasp to grasp, both included; the palm moves straight.
};

/// Why there is none.
struct ReachRefusal {
  std::string reason;            ///< By the posture that got farthest, with numbers.
  std::optional<double> miss_m;  ///< By how much, where that is a length.
};

/// Finds arm postures for grasps: distance of the wrist from the shoulder first, then every branch and elbow
/// angle of the inverse kinematics, best first, through grasp, pre-grasp, the straight way between them and
/// the lift, each on one branch and free of collision by the fast checker. Keeps buffers: one thread.
class GraspReach {
 public:
  /// `model`, `arm`, `config` and `checker` have to outlive it. Sets what the checker allows.
  GraspReach(const hal::RobotModel& model, const ArmGeometry& arm, const PlannerConfig& config,
             FastChecker& checker);

  /// Up to `most` postures that differ from each other, best score first; none with `why` said.
  [[nodiscard]] std::vector<GraspPosture> find(const ReachQuery& query, std::size_t most, ReachRefusal& why);

 private:
  enum class Stage { Grasp, BackLimits, PreGrasp, Approach, LiftLimits, Lift };
  /// Where the postures ended that did not get through.
  struct Ends {
    Stage farthest = Stage::Grasp;
    int postures = 0;                               ///< That ended at that stage.
    JointPath at;                                   ///< Way of the first one there: a state or an edge.
    double followed_m = 0.0, of_m = 0.0;            ///< For the stages of limits.
    Contacts contacts = Contacts::FingersOnTarget;  ///< What was allowed there.
    bool any = false;
  };

  [[nodiscard]] std::optional<ReachRefusal> too_far(const hal::Pose& X_WF, const char* where) const;
  [[nodiscard]] bool pass(const ReachQuery& query, const hal::Pose& X_WF, const ScoredIk& ik,
                          GraspPosture& out);
  void ended(Stage stage, JointPath at, Contacts contacts, double followed_m = 0.0, double of_m = 0.0);
  [[nodiscard]] ReachRefusal explain() const;
  [[nodiscard]] Touch touch_along(const JointPath& way, Contacts contacts) const;
  [[nodiscard]] bool hand_alone(const Touch& touch) const;

  const hal::RobotModel& model_;
  const ArmGeometry& arm_;
  const PlannerConfig& config_;
  FastChecker& checker_;
  Ends ends_;
  JointPath back_, lift_;
};

}  // namespace colift::planner
