#pragma once

#include <algorithm>
#include <cstdint>
#include <memory>
#include <string>

#include "control/config/setpoint_limits.hpp"
#include "control/config/task_config.hpp"
#include "control/lift/load_estimator.hpp"
#include "hal/arm.hpp"
#include "hal/guards/cycle_time.hpp"
#include "hal/robot_model/robot_model.hpp"
#include "planner/motion/trajectory/trajectory.hpp"

namespace colift::control {

/// Makes exactly one command for each cycle of the arm: holds, follows a planned trajectory, or serves a set
/// point, always within limits and without a step in position or velocity. One thread; step() does not
/// allocate.
///
/// The first command, and the first after may_command was lost or the states had a gap, is the measured pose
/// at rest: whatever was going on is over then (starts() tells), and the cycle holds. A trajectory that was
/// cut off like that can be taken up again with resume() or back(), from where the arm stands.
///
/// While the controller warns (ArmState::slow), and when asked to, trajectories run with
/// TaskConfig::slow_fraction of their speed; the change is as smooth as a stop.
class SetpointGenerator {
 public:
  enum class Contact { None, Force, Lag };
  /// What ended a trajectory, and the limit that it broke.
  struct Blockage {
    Contact why = Contact::None;
    double force_n = 0.0, force_limit_n = 0.0;
    int joint = 0;  ///< That lags most, from 0.
    double lag_rad = 0.0, lag_limit_rad = 0.0;
  };

  SetpointGenerator(const hal::RobotModel& model, const TaskConfig& task, const SetpointLimits& limits = {});

  /// Comes to rest (a trajectory: on the path) and stays there. A halted trajectory can be resumed or run
  /// back.
  void hold();
  /// The same, with SetpointLimits::urgent_factor of deceleration and jerk; set points that are served then
  /// are followed with it too, until the next trajectory or end_urgency().
  void hold_urgently();
  void end_urgency() { urgency_ = 1.0; }
  /// Starts a trajectory at its first cycle. Errors: NotReady (not at rest), BadInput (no trajectory, or it
  /// starts elsewhere than the arm is commanded to: by how much, in which joint). Plan from commanded(), not
  /// from the measured pose: the arm's springs are loaded.
  [[nodiscard]] hal::Result<> follow(std::shared_ptr<const planner::Trajectory> trajectory);
  /// Goes on along the halted trajectory with `speed` (0 to 1) of its planned speed; also slows a running
  /// one. After a start from the measured pose it joins the trajectory at its nearest point, first at rest.
  /// False, and nothing happens, when the arm has left the trajectory: by servo(), or by more than
  /// SetpointLimits::start_tolerance_rad.
  bool resume(double speed = 1.0);
  /// goes back along its path, to its start, also from its end, with `speed` of the planned speed; else as
  /// resume().
  bool back(double speed = 1.0);
  /// Serves a set point, given anew in every cycle by whoever knows it: joint positions, and the torque to be
  /// added (ramped). A set point that runs away is followed within limits, without overshoot.
  void servo(const hal::JointVector& q_rad, const hal::JointVector& tau_superposed_nm);
  /// Torque to be added from now on, ramped and limited; hold() and follow() keep it, so that a load stays
  /// borne: set it to zero when the hand is empty.
  void superpose(const hal::JointVector& tau_nm);
  /// Stiffness from now on, ramped with `slope_nm_rad_s` (0: SetpointLimits); TaskConfig's at first.
  void set_stiffness(double nm_rad, double slope_nm_rad_s = 0.0);
  /// Part of its slope that a growing stiffness may have from now on, 0 to 1: springs that return raise what
  /// hangs on them, without any set point.
  void limit_stiffening(double part) { stiffening_ = std::clamp(part, 0.0, 1.0); }
  [[nodiscard]] double stiffness() const { return stiffness_; }
  [[nodiscard]] const hal::JointVector& superposed() const { return tau_goal_; }
  [[nodiscard]] bool follows_trajectory() const { return mode_ == Mode::Trajectory; }
  /// Slower until further notice, whatever the controller says.
  void go_slow(bool on) { asked_slow_ = on; }
  /// At most this fraction of the speed from now on, 0 to 1; NaN counts as 0. At 0 it comes to rest on the
  /// trajectory, or in a lift where it is, and is not done.
  void set_scale(double scale) { asked_scale_ = scale > 0.0 ? std::min(scale, 1.0) : 0.0; }

  /// The answer to one cycle.
  [[nodiscard]] hal::ImpedanceCommand step(const hal::ArmState& state);

  /// At rest where it was sent: at the trajectory's end (after back(): its start; after hold(): anywhere), at
  /// the set point. A trajectory that was cut off is not done.
  [[nodiscard]] bool done() const;
  [[nodiscard]] bool at_rest() const;
  /// Part of the trajectory that lies behind (where it was cut off), 0 to 1; 1 without a trajectory.
  [[nodiscard]] double progress() const;
  /// Joint positions of the last command.
  [[nodiscard]] const hal::JointVector& commanded() const { return q_; }
  /// Counts the starts from the measured pose; a change says that a motion was cut off.
  [[nodiscard]] std::uint32_t starts() const { return starts_; }
  /// The controller takes commands; else the cycle repeats the measured pose.
  [[nodiscard]] bool running() const { return running_; }
  /// Part of the speed that is to be used now, 1 or changing to TaskConfig::slow_fraction; for whoever feeds
  /// servo().
  [[nodiscard]] double pace() const { return pace_; }
  [[nodiscard]] bool slow() const { return slow_left_s_ > 0.0; }

  /// While a trajectory is followed: a force at the palm above TaskConfig::contact_n against both of its
  /// zeros, what was felt before this trajectory began and before the first one since the arm was started; or
  /// an arm that does not follow. Latched until the next follow(), resume() or back(). The watch only tells;
  /// whoever asks calls hold().
  [[nodiscard]] bool blocked() const { return blocked_.why != Contact::None; }
  /// Why, with numbers; describe() makes a sentence of it.
  [[nodiscard]] const Blockage& blockage() const { return blocked_; }
  /// Force at the palm against the nearer of these zeros (N).
  [[nodiscard]] double contact_force_n() const;

 private:
  enum class Mode { Hold, Trajectory, Servo };

  void start_from(const hal::ArmState& state, bool usable);
  void step_hold(double dt_s);
  void step_trajectory(double dt_s);
  void step_servo(double dt_s);
  void watch(const hal::ArmState& state, double dt_s);
  void set_pace(bool slow, double dt_s);
  /// Fraction of the planned speed that is asked for now.
  [[nodiscard]] double speed_goal() const { return std::min(slow() ? slow_part_ : 1.0, asked_scale_); }
  bool run_along(double rate);
  bool rejoin();

  const hal::RobotModel* model_;
  SetpointLimits limits_;
  double contact_limit_n_, slow_part_;
  hal::JointVector lower_, upper_, velocity_, superposed_;

  Mode mode_ = Mode::Hold;
  bool running_ = false;  ///< A first command was made, and no gap came since.
  std::uint32_t starts_ = 0;
  hal::CycleTime time_;

  hal::JointVector q_ = hal::JointVector::Zero(), dq_ = hal::JointVector::Zero();
  hal::JointVector servo_q_ = hal::JointVector::Zero(), servo_before_ = hal::JointVector::Zero();
  hal::JointVector tau_ = hal::JointVector::Zero(), tau_goal_ = hal::JointVector::Zero();
  double stiffness_, stiffness_goal_, stiffness_slope_, stiffening_ = 1.0;

  std::shared_ptr<const planner::Trajectory> trajectory_;
  bool on_trajectory_ = false;  ///< The command stands on the trajectory: it can be run on and back.
  bool cut_off_ = false;  ///< It did until a start from the measured pose, and nothing else was asked since.
  bool along_ = false;    ///< The last that was asked for is to move along the trajectory.
  hal::JointVector trajectory_offset_ =
      hal::JointVector::Zero();  ///< Command minus trajectory when it was joined ...
  double joined_s_ = 0.0;        ///< ... so long ago; blended out.
  double trajectory_s_ = 0.0, rate_ = 0.0, rate_slope_ = 0.0, rate_goal_ = 0.0;
  bool asked_slow_ = false;
  double asked_scale_ = 1.0;
  double urgency_ = 1.0;  ///< Multiple of deceleration and jerk, until the next motion.
  double pace_ = 1.0, slow_left_s_ = 0.0;

  bool armed_ = true;
  Blockage blocked_;
  /// A trajectory that begins in a contact takes it for its zero, and would feel it as a force once it is
  /// gone.
  hal::Wrench contact_, first_contact_;
  struct Tare {
    hal::JointVector rise_m = hal::JointVector::Zero(), tau_nm = hal::JointVector::Zero();
  };
  hal::JointVector rest_tau_ = hal::JointVector::Zero();
  Tare tare_, first_tare_;
  bool first_since_start_ = true;
  double rested_s_ = 0.0;  ///< Since the last motion.
  hal::JointVector rest_lag_ = hal::JointVector::Zero(), lag_at_start_ = hal::JointVector::Zero();
};

/// Whether a trajectory can begin. Errors: NotReady (not commanded; moving), BadInput (it is empty, or starts
/// elsewhere than `commanded`: by how much, in which joint).
[[nodiscard]] hal::Result<> can_follow(const planner::Trajectory& trajectory, bool running, bool at_rest,
                                       const hal::JointVector& commanded_rad, const SetpointLimits& limits);

/// A blockage as a sentence with numbers; empty when there is none.
[[nodiscard]] std::string describe(const SetpointGenerator::Blockage& blockage);

}  // namespace colift::control
