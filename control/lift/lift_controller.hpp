#pragma once

#include <optional>

#include "control/config/task_config.hpp"
#include "control/lift/tilt_compliance.hpp"
#include "hal/robot_model/robot_model.hpp"
#include "hal/types/geometry.hpp"
#include "planner/motion/inverse_kinematics/arm_ik.hpp"

namespace colift::control {

/// Raises, holds and lowers the palm. Leading, the palm follows a minimum-jerk profile and the partner comes
/// along; following, it goes where the partner's end of the object goes, so that the object stays level. What
/// the hand bears is fed forward, so that the impedance does not sag; what pushes it up is not. About the
/// axis across the line of the hands the palm gives way (TiltCompliance). Allocation-free.
class LiftController {
 public:
  enum class Role { Lead, Follow };

  /// Joint position and torque for one cycle.
  struct Command {
    hal::JointVector q_rad = hal::JointVector::Zero();
    hal::JointVector tau_superposed_nm = hal::JointVector::Zero();
  };

  LiftController(const hal::RobotModel& model, const planner::ArmGeometry& arm, const TaskConfig& config);

  /// The hand has closed with the arm commanded here; heights count from now on. Without a line of the hands
  /// the palm is not turned.
  void start(const hal::JointVector& q_commanded_rad, const HandLine& line = {});

  /// From now on the palm gives way about the axis across this line, if it did not yet: a test lift is
  /// raised with a stiff palm, the lift after it is not.
  void give_way(const HandLine& line);
  /// To this height over where the hand closed, in this time when leading; on from the present height.
  void lift(Role role, double height_m, double time_s);
  /// Goes no further, and leads: at once, so from a slow lift only.
  void stay();
  void lower();
  /// The arm was cut off and stands here, at rest: goes on to the same height from where it is, without a
  /// step. What little it was turned or shifted by stays.
  void restart(const hal::JointVector& q_commanded_rad);

  /// The commanded joints, but with the palm where it stands now: taken aside or turned by the partner, or
  /// held up by what it leans on. Not lower: what a load has pulled down comes up again with the empty hand.
  /// As commanded where that is farther than a hand's breadth or out of reach.
  [[nodiscard]] hal::JointVector where_taken(const hal::JointVector& q_commanded_rad,
                                             const hal::JointVector& q_measured_rad) const;

  /// How far the partner's end of the object has risen, whenever it was seen (m).
  void see_partner(double rise_m) { partner_rise_m_ = rise_m; }

  /// One cycle of `dt_s`; `felt` is the wrench of the environment on the hand about the palm, in W; `pace` is
  /// the part of its speed that the palm moves with. nullopt when the arm cannot follow: a joint limit or a
  /// singularity lies on the way.
  [[nodiscard]] std::optional<Command> step(double dt_s, const std::optional<hal::Wrench>& measured,
                                            double pace = 1.0);

  [[nodiscard]] double height_m() const { return height_m_; }  ///< Commanded, over where the hand closed.
  [[nodiscard]] bool at_rest() const;                          ///< The commanded height has reached its goal.
  [[nodiscard]] bool rises() const { return to_m_ > height_m_; }
  [[nodiscard]] Role role() const { return role_; }

 private:
  void aim(double to_m, double time_s);
  [[nodiscard]] double next_height(double dt_s);
  [[nodiscard]] hal::Pose compliant(const hal::Pose& X_WF) const;

  const hal::RobotModel* model_;
  planner::ArmGeometry arm_;
  TaskConfig config_;
  Role role_ = Role::Lead;
  hal::Pose X_WF0_ = hal::Pose::Identity();
  hal::Pose X_FH_ = hal::Pose::Identity();
  HandLine line_;
  TiltCompliance compliance_;
  hal::JointVector q_rad_ = hal::JointVector::Zero();
  double height_m_ = 0.0, speed_m_s_ = 0.0;
  double from_m_ = 0.0, to_m_ = 0.0, time_s_ = 0.0, span_s_ = 0.0;  ///< Of the profile.
  double s_per_m_ = 0.0;                                            ///< How slowly it was asked for.
  double partner_rise_m_ = 0.0;
  bool at_end_ = false;  ///< Of the reach, until another height is asked for.
  hal::Wrench fed_;      ///< Low-pass of what is felt, without the horizontal forces.
};

}  // namespace colift::control
