#pragma once

// Inside of TaskRunner: what is known during one job, and what is done in each state. Not for other folders.

#include <cmath>
#include <optional>
#include <string>

#include "control/arm/arm_commander.hpp"
#include "control/task/task_runner.hpp"
#include "control/test_lift/test_lifts.hpp"

namespace colift::control {

/// An event and what is to be said about it, beyond the rule's own words.
struct Happening {
  Event event;
  std::string detail;
};

constexpr double kBackSpeed = 0.6;  ///< Of the planned speed, on the way back.

class Job {
 public:
  Job(hal::Robot& robot, const RigView& rig, const Config& config, const JobOptions& options,
      const hal::Clock& stopwatch);

  [[nodiscard]] hal::Result<> start_devices();
  /// One cycle: news of the devices, work of the state, change of state, command. False when the job has
  /// ended.
  bool cycle(const JobHooks& hooks);
  /// Lets the devices rest and closes the record.
  RunRecord finish();

 private:
  // arm.cpp: whether the arm is there, and what is done when it stood for a while
  void read_arm();
  void stand();
  void take_up();
  [[nodiscard]] bool waits_for_arm() const;

  // devices.cpp: what the devices say
  void read_devices();
  void read_camera();
  void lose(const std::string& device, const std::string& what);

  // pace.cpp: how fast the arm may go
  void judge_pictures();
  void set_pace();
  [[nodiscard]] std::optional<Happening> emergency(const JobHooks& hooks);

  // before_contact.cpp: from Observe to the closing hand
  [[nodiscard]] std::optional<Happening> observe();
  /// A look that shows something to carry becomes what the job knows.
  void take_look();
  [[nodiscard]] std::optional<Happening> await_partner();
  [[nodiscard]] std::optional<Happening> decide();
  [[nodiscard]] std::optional<Happening> plan();
  [[nodiscard]] Happening find_way();
  [[nodiscard]] std::optional<Happening> approach();
  [[nodiscard]] std::optional<Happening> halt();
  [[nodiscard]] std::optional<Happening> back_off();
  /// Looks at a new frame for the partner; what he did, if anything.
  std::optional<perception::PartnerEvent> watch_partner();
  [[nodiscard]] bool choose();
  /// Sets to Unreachable what the arm does not reach; where it does not get there straight, but at an angle
  /// to the face, the candidate becomes that one.
  void judge_reach(std::vector<planner::GraspCandidate>& candidates);
  void apply_refusals(std::vector<planner::GraspCandidate>& candidates) const;
  /// Whether he still holds where he was asked to leave.
  [[nodiscard]] bool stays_where_he_was() const;
  [[nodiscard]] bool ask_partner();

  // test_lift.cpp: a little, slowly, and what follows
  void begin_test_lift();
  [[nodiscard]] std::optional<Happening> test_lift();
  [[nodiscard]] Happening judge_test_lift();
  [[nodiscard]] double test_height_m() const;
  [[nodiscard]] bool choose_level(const perception::PartnerGrasp& partner, const Judge& reach);

  // with_object.cpp: from the closing hand to the way home
  [[nodiscard]] std::optional<Happening> close();
  [[nodiscard]] std::optional<Happening> verify();
  [[nodiscard]] std::optional<Happening> await_ready();
  [[nodiscard]] std::optional<Happening> lift();
  [[nodiscard]] std::optional<Happening> hold();
  [[nodiscard]] std::optional<Happening> lower();
  [[nodiscard]] std::optional<Happening> release();
  [[nodiscard]] std::optional<Happening> retreat();
  void back_to_pre_grasp();
  [[nodiscard]] double object_moved_m() const;
  /// The object was put down elsewhere: scene, candidates and test lifts become those of where it stands now.
  /// Empty, or why that cannot be.
  [[nodiscard]] std::string take_scene_as_moved();
  void refuse_grip(const std::string& why);
  void watch_object();
  [[nodiscard]] std::optional<Happening> serve_lift() const;
  [[nodiscard]] std::optional<Happening> beyond_limits() const;
  void summarise_hold();

  [[nodiscard]] std::optional<Happening> work();
  void apply(const Happening& happening, const JobHooks& hooks);
  void enter(Task from);
  void tell(const JobHooks& hooks);
  [[nodiscard]] bool follow(const planner::Trajectory& way);

  [[nodiscard]] double in_state_s() const { return hal::seconds(now_ - since_); }
  [[nodiscard]] RobotPosture posture() const { return {arm_.q_rad, hal::posture_of(hand_)}; }
  [[nodiscard]] hal::Pose palm() const { return hal::hand_pose(rig_.model, arm_.q_rad); }

  hal::Robot& robot_;
  RigView rig_;
  Config config_;
  JobOptions options_;
  const hal::Clock& stopwatch_;
  planner::ArmGeometry geometry_;

  Task state_ = Task::Observe;
  hal::Timestamp now_{0}, began_{0}, since_{0}, told_{0}, wall_start_{0};
  RunRecord record_;
  std::string doing_, partner_note_;
  std::optional<double> done_;

  // devices
  hal::ArmState arm_;
  hal::HandState hand_;
  std::optional<hal::DepthFrame> frame_;  ///< New in this cycle.
  std::vector<float> last_depth_m_;
  hal::Timestamp frame_at_{0}, hand_at_{0}, reopen_at_{0};
  bool camera_lost_ = false, hand_silent_ = false, arm_silent_ = false, had_command_ = false;
  std::optional<hal::Timestamp> stands_since_;  ///< The arm's controller takes no commands since.
  std::uint32_t starts_ = 0;                    ///< Of the arm's cycle, as far as is known.
  bool cut_off_ = false;                        ///< It began anew since the task looked last.
  bool slow_ = false;
  std::string slow_because_;  ///< Why the arm was asked to; empty: it was not.
  hal::Timestamp aged_at_{0};
  double picture_age_s_ = 0.0;     ///< Of the newest picture, in the mean.
  hal::Duration picture_late_{0};  ///< Age of the newest one when it came.
  bool pictures_old_ = false;
  /// The one puck that does not answer while the others do, 0 to 2 a finger, 3 the spread; and the one that
  /// the hand was opened without.
  std::optional<std::size_t> puck_alone_, without_puck_;
  std::string arm_trouble_, hand_trouble_, hand_warning_;

  // before contact
  Watch watch_;
  std::unique_ptr<planner::MotionPlanner> planner_;
  hal::JointVector home_rad_ = hal::JointVector::Zero();
  ArmCommander loop_;
  std::vector<planner::GraspCandidate>
      judged_;  ///< Of the look, with reach: what every decision starts from.
  std::vector<planner::GraspCandidate> refused_;  ///< In this decision, because no way leads there.
  struct FailedGrip {
    hal::Vec3 position;
    std::string why;
  };
  std::vector<FailedGrip> failed_grips_;
  double see_ms_ = 0.0;
  /// Of the way there: -1 it could not begin, 0 transit, 1 straight approach; back: 2 braking, 3 back, 4
  /// home.
  int leg_ = 0;
  bool was_near_ = false;  ///< The way back began on the straight approach.
  bool moved_ = false;
  int approaches_ = 0;
  bool refusal_told_ = false;
  std::string look_trouble_;  ///< Why the last picture of the scene was not good enough.
  Event off_because_ = Event::PartnerMoved;
  hal::Timestamp waits_since_{0};

  // test lifts
  TestLifts tests_;
  bool test_at_top_ = false;  ///< The one that goes on is raised no more: it is measured.
  struct Bearable {
    planner::GraspCandidate grasp;
    double share = 0.0, tilt_rad = 0.0;
  };
  std::optional<Bearable> bearable_;  ///< The most level grip that was put down again.
  bool accepts_bearable_ = false;     ///< There is no better one.
  bool regrasp_ = false;              ///< On the way back, to take hold elsewhere.

  // what the partner was asked
  struct Asked {
    hal::Vec3 from, to;
    std::string because, why;  ///< What he is told; the whole reason.
  };
  std::optional<Asked> asked_;
  int times_asked_ = 0;

  // with the object
  LiftController::Role role_ = LiftController::Role::Lead;
  hal::Pose X_WH_closed_ = hal::Pose::Identity();
  std::optional<perception::ObjectMotion> motion_;
  hal::Timestamp settled_at_{0}, unloaded_since_{0};
  double partner_rise_m_ = 0.0, partner_top_m_ = 0.0, tilt_rad_ = NAN, slip_m_ = NAN;
  int slipping_ = 0, tilting_ = 0;
  double hold_load_n_ = NAN;
  double lift_s_ = 0.0;  ///< That the lift takes which goes on.
  bool lifted_ = false;
  bool failed_ = false;  ///< The job goes home without its goal.
  std::string failed_because_, last_because_;
};

}  // namespace colift::control
