#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "hal/config/range.hpp"
#include "hal/types/result.hpp"
#include "hal/types/time.hpp"
#include "planner/grasp_candidate.hpp"
#include "planner/hand/hand_model.hpp"
#include "planner/motion/collision/collision_scene.hpp"
#include "planner/motion/inverse_kinematics/arm_ik.hpp"
#include "planner/motion/search_config.hpp"
#include "planner/motion/trajectory/trajectory.hpp"

namespace colift::planner {

/// How paths are searched, and how fast they are travelled.
struct PlannerConfig {
  double pre_grasp_m = 0.10;
  double lift_margin_m = 0.03;
  double limit_margin_deg = 3.0;
  double step_rad = 0.045;
  double cartesian_step_m = 0.01;
  int elbow_steps = 24;
  int goals = 8;
  double planning_budget_s = 0.5;
  double exact_step_rad = 0.03;
  double blend_rad = 0.05;
  double approach_speed_m_s = 0.10;
  double transit_speed_m_s = 0.25;
  double velocity_fraction = 0.5;
  double max_joint_rad_s = 4.0;
  double acceleration_rad_s2 = 2.0;
  double jerk_rad_s3 = 20.0;
  SearchConfig search;
  SceneConfig scene;

  template <class Visitor>
  void visit(Visitor& v) {
    v("pre_grasp_m", pre_grasp_m, hal::Range{0.02, 0.5},
      "Length of the straight path along the approach direction before the grasp (m).");
    v("lift_margin_m", lift_margin_m, hal::Range{0, 0.3},
      "Height above the top of the lift that the arm must reach too, to follow the partner (m).");
    v("limit_margin_deg", limit_margin_deg, hal::Range{0, 20},
      "Distance that plans keep from joint limits (deg).");
    v("step_rad", step_rad, hal::Range{0.005, 0.3},
      "Step of the fast check along a motion (rad in any joint).");
    v("cartesian_step_m", cartesian_step_m, hal::Range{0.001, 0.05},
      "Step along straight paths of the hand (m).");
    v("elbow_steps", elbow_steps, hal::Range{4, 360}, "Number of elbow angles that are tried for a pose.");
    v("goals", goals, hal::Range{1, 64},
      "Max number of joint positions of the pre-grasp that are planned to, best first.");
    v("planning_budget_s", planning_budget_s, hal::Range{0.01, 30},
      "Timeout of the search for a path (s, as work at the speed of docs/benchmarks.md: the same on every "
      "machine).");
    v.renamed("plan_s", "planning_budget_s");
    v("exact_step_rad", exact_step_rad, hal::Range{0.005, 0.3},
      "Step of the exact check of a final path (rad).");
    v("blend_rad", blend_rad, hal::Range{0, 0.5},
      "Max deviation of the trajectory from the corners of its path (rad).");
    v("approach_speed_m_s", approach_speed_m_s, hal::Range{0.01, 0.25},
      "Speed of the palm along the approach (m/s).");
    v("transit_speed_m_s", transit_speed_m_s, hal::Range{0.01, 1.0},
      "Max speed of the palm elsewhere (m/s).");
    v("velocity_fraction", velocity_fraction, hal::kFraction,
      "Fraction of the joints' own velocity limits that is used.");
    v.renamed("joint_speed", "velocity_fraction");
    v("max_joint_rad_s", max_joint_rad_s, hal::kPositive, "Max planned speed of any joint (rad/s).");
    v("acceleration_rad_s2", acceleration_rad_s2, hal::kPositive, "Max joint acceleration (rad/s^2).");
    v("jerk_rad_s3", jerk_rad_s3, hal::kPositive, "Max joint jerk (rad/s^3).");
    v("search", search, "How a collision-free path is searched and shortened.");
    v("scene", scene, "What counts as an obstacle.");
  }
};

/// Of a planned motion: those of the configuration, and no joint faster than that fraction of its own limit.
[[nodiscard]] MotionLimits limits_of(const hal::RobotModel& model, const PlannerConfig& config);

/// Whether the arm gets to a grasp and through the lift: joint positions that belong together.
struct Reach {
  hal::JointVector pre_grasp_rad = hal::JointVector::Zero(), grasp_rad = hal::JointVector::Zero(),
                   lifted_rad = hal::JointVector::Zero();
  double score = 0.0;
};

/// The way to a grasp and through it. Retreat is approach and transit backwards.
struct MotionPlan {
  Trajectory transit;   ///< Start to pre-grasp.
  Trajectory approach;  ///< Straight along the approach direction.
  Trajectory retreat;   ///< Straight back from the grasp, hand open.
  Trajectory home;      ///< Pre-grasp to start.
  Reach reach;
  hal::Pose X_WH_grasp = hal::Pose::Identity();
  std::string note;  ///< What is unusual about it ("at the start the forearm comes ..."); mostly empty.
  /// Where the time went (0 without a clock): reach and search, shortcuts, rounding and timing, exact check.
  double plan_ms = 0.0, shortcut_ms = 0.0, trajectory_ms = 0.0, exact_ms = 0.0;
  std::size_t states_checked = 0;  ///< By the fast checker.
};

/// Plans motions in one collision scene. Deterministic for a seed. One planner, one thread.
class MotionPlanner {
 public:
  /// `clock` only times the stages of a plan; it may be null, and has to outlive the planner.
  MotionPlanner(const hal::RobotModel& model, const HandModel& hand, const PlannerConfig& config,
                std::uint64_t seed, const hal::Clock* clock = nullptr);
  ~MotionPlanner();
  MotionPlanner(MotionPlanner&&) noexcept;
  MotionPlanner& operator=(MotionPlanner&&) noexcept;

  /// A new collision world; what was judged before is forgotten. The map has to outlive its use here.
  void set_scene(std::shared_ptr<const CollisionScene> scene, const perception::WorldMap& map,
                 const hal::Vec3& up);

  /// Whether grasp, pre-grasp and the lift by `lift_m` can be reached without collision, by inverse
  /// kinematics and the fast checker; else why not ("the wrist would have to go 83 mm beyond the arm's
  /// reach"). About 50 us.
  [[nodiscard]] tl::expected<Reach, std::string> reach(const GraspCandidate& grasp, double lift_m);
  /// Sets every Ok candidate that is out of reach to Unreachable with the reason.
  void judge(std::vector<GraspCandidate>& candidates, double lift_m);

  /// From a joint position to the grasp. Errors: NotFound with the step that failed and why (start, reach,
  /// goal, transit, approach, exact check).
  [[nodiscard]] hal::Result<MotionPlan> plan(const hal::JointVector& start_rad, const GraspCandidate& grasp,
                                             double lift_m);
  /// From anywhere to a joint position with an open hand. Errors: as plan().
  [[nodiscard]] hal::Result<Trajectory> plan_to(const hal::JointVector& start_rad,
                                                const hal::JointVector& goal_rad);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace colift::planner
