#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "control/arm/arm_commander.hpp"
#include "control/session/perception_session.hpp"
#include "control/task/job_status.hpp"
#include "control/task/posture_history.hpp"
#include "control/task/run_record.hpp"
#include "control/test_lift/test_lifts.hpp"
#include "hal/robot.hpp"
#include "planner/motion/motion_planner.hpp"

namespace colift::control {

/// An event of the task machine, and what is to be said about it beyond the rule's own words.
struct TaskEvent {
  Event event;
  std::string detail;
};

/// What the devices said last; the supervisors write it, the phases read it.
struct DeviceReadings {
  hal::ArmState arm;
  hal::HandState hand;
  std::optional<hal::DepthFrame> frame;  ///< New in this cycle.
  hal::Timestamp frame_at{0};            ///< Exposure of the newest good frame.
  hal::Duration frame_latency{0};        ///< Age of that frame when it came.
  bool camera_lost = false;
  /// The puck that the hand was opened without, because it did not answer: 0 to 2 a finger, 3 the spread.
  std::optional<std::size_t> without_puck;
};

/// What the attempts of this job came to, as far as later phases depend on it.
struct Attempts {
  int approaches = 0;   ///< How often the arm set out to a grasp.
  bool lifted = false;  ///< A whole lift was begun; a test lift is none.
  bool failed = false;  ///< The job goes home without its goal.
  /// On the way home, to grasp elsewhere: a test lift said so.
  bool regrasp = false;
  bool touched = false;  ///< On the way home, because the open hand met something at the object.
  std::string failure;   ///< Why the last thing that failed did; empty: nothing has.
};

/// What all phases of one job share: what it was given, the arm, the perception session, the planner, time
/// and state, and the record. What one phase alone needs is that phase's own.
struct TaskContext {
  TaskContext(hal::Robot& robot, const RigView& rig, const Config& config, const JobOptions& options,
              const hal::Clock& stopwatch);
  TaskContext(const TaskContext&) = delete;
  TaskContext& operator=(const TaskContext&) = delete;

  /// Starts the arm along a trajectory; an empty one is none. False when it cannot; attempts.failure says
  /// why.
  [[nodiscard]] bool follow(const planner::Trajectory& trajectory);
  /// Whether a motion may begin: it was announced TaskConfig::intent_lead_s ago, and the arm takes commands,
  /// which after a gap of its cycle it does not for a moment. To be asked in every cycle.
  [[nodiscard]] bool may_begin(Motion motion) {
    return intents.may_begin(motion, now - began) && arm.view().running;
  }
  /// Says something to the people around the robot.
  void request(std::string says) { intents.request(std::move(says), now - began); }
  /// Something about a device is worth saying.
  void note_device(const std::string& device, const std::string& what);

  /// The arm moves in this state, or would if nobody were near it.
  [[nodiscard]] bool arm_moves() const { return is_moving(state) || (state == Task::Release && sets_down); }
  /// Time in this state, without the time for which the arm waited for somebody to go away.
  [[nodiscard]] double in_state_s() const { return hal::seconds(now - since) - waited_s; }
  [[nodiscard]] RobotPosture posture() const { return {readings.arm.q_rad, hal::posture_of(readings.hand)}; }
  [[nodiscard]] hal::Pose palm() const { return hal::hand_pose(rig.model, readings.arm.q_rad); }
  /// Plans are made in the session's map as it is now.
  void use_map();
  /// Before a decision: what was carried off since the scene was seen is no obstacle any more. Returns how
  /// many cells became free.
  std::size_t renew_map();
  /// The newest frame shows the object there: X takes a point of it from where the scene has it (W).
  void see_object(const hal::Pose& X_Wnow_Wscene);
  /// A copy of this cycle's frame for pictures of the scene; nothing while another camera leads than the one
  /// that the scene is seen by.
  [[nodiscard]] std::optional<hal::DepthFrame> picture() const {
    if (!readings.frame || session.leading() != session.scene_camera()) return std::nullopt;
    return session.corrected(*readings.frame);
  }
  /// Of the object: as it was given, else as a test lift measured it.
  [[nodiscard]] std::optional<double> mass_kg() const;
  /// The grasp that was decided on. There has to be one.
  [[nodiscard]] const planner::GraspCandidate& chosen() const;
  /// Between the chosen grasp and the partner's hand. There has to be a decision.
  [[nodiscard]] HandLine hand_line() const;

  hal::Robot& robot;
  RigView rig;
  Config config;
  JobOptions options;
  const hal::Clock& stopwatch;  ///< Measures computing time only.

  ArmCommander arm;
  PerceptionSession session;
  planner::MotionPlanner motion_planner;

  Task state = Task::Observe;
  hal::Timestamp now{0}, began{0}, since{0};  ///< Of the robot's clock; `since`: in this state.
  bool arm_waits = false;                     ///< For somebody near it: it stands on its path.
  bool sets_down = false;                     ///< A release lowers the palm before the hand opens.
  double waited_s = 0.0;  ///< Of the time in this state; a slowed arm's counts in proportion.

  std::optional<std::size_t> bodies_in_view;  ///< Foreign ones, in the last frame; unset: not looked for.
  int map_version = 0;                        ///< Counts the maps that plans were made in.
  /// The collision world without people, as the session's map has it; plans add those who are there.
  std::shared_ptr<const planner::CollisionScene> empty_scene;
  /// Points of things that nobody knew of when the scene was seen, and of all that obstructed the last path,
  /// without the partner (W): new paths keep away from them.
  std::vector<Eigen::Vector3f> obstacles_W;
  double obstacle_clearance_m = 0.0;  ///< From these, so that the monitor lets the arm pass.

  DeviceReadings readings;
  PostureHistory past;   ///< Of the robot, for frames that come late.
  TrackedPoses tracked;  ///< In the frame of this cycle.
  Attempts attempts;
  double carry_scale = 1.0;  ///< Of the palm's speed, as JobPolicies::carry wants it.
  LiftController::Role role = LiftController::Role::Lead;  ///< Of the next lift.
  TestLifts test_lifts;
  RunRecord record;
  IntentAnnouncer intents{config.task.intent_lead_s, record.intents};

  // for the status report
  std::string doing;           ///< What the state is doing in particular.
  std::optional<double> done;  ///< Fraction of its work, 0 to 1.
  std::string partner_note;    ///< What was last seen of the partner.
};

}  // namespace colift::control
