#include "control/arm/setpoint_generator.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "control/arm/contact_wrench.hpp"
#include "hal/guards/braking_law.hpp"

namespace colift::control {

namespace {

constexpr double kAtRest_rad_s = 1e-9;   // of what is commanded: rounding errors only
constexpr double kGapCycles = 5.5;       // the controller moves on by itself over no more
constexpr double kRejoin_s = 0.5;        // searched: of a trajectory, on both sides of where it was cut off
constexpr int kRejoinSteps = 50;         // of 10 ms: a few cycles
constexpr double kRateSlope_s = 25.0;    // 1/s: where a trajectory hardly moves its speed may change at once
constexpr double kRateJerk_s2 = 2500.0;  // 1/s^2

hal::JointBounds bounds_of(const hal::JointVector& lower, const hal::JointVector& upper,
                           const hal::JointVector& velocity, double acceleration, int i) {
  return {lower[i], upper[i], velocity[i], acceleration};
}

/// From 1 to 0 in the first `blend_s` on the trajectory, at rest at both ends.
double offset_left(double joined_s, double blend_s) {
  const double x = std::clamp(joined_s / blend_s, 0.0, 1.0);
  return 1.0 - x * x * x * (10.0 + x * (-15.0 + 6.0 * x));
}

double towards(double from, double to, double most) {
  return from + std::clamp(to - from, -most, most);
}

}  // namespace

SetpointGenerator::SetpointGenerator(const hal::RobotModel& model, const TaskConfig& task,
                                     const SetpointLimits& limits)
    : model_(&model),
      limits_(limits),
      contact_limit_n_(task.contact_n),
      slow_part_(task.slow_fraction),
      lower_(model.lower_rad().array() + limits.limit_margin_rad),
      upper_(model.upper_rad().array() - limits.limit_margin_rad),
      velocity_((limits.velocity_fraction * model.velocity_rad_s()).cwiseMin(limits.velocity_rad_s)),
      superposed_(model.effort_nm().cwiseMin(limits.superposed_nm)),
      stiffness_(task.stiffness_nm_rad),
      stiffness_goal_(task.stiffness_nm_rad),
      stiffness_slope_(limits.stiffness_slope_nm_rad_s) {}

void SetpointGenerator::hold_urgently() {
  hold();
  urgency_ = limits_.urgent_factor;
}

void SetpointGenerator::hold() {
  along_ = false;
  if (mode_ == Mode::Trajectory)
    rate_goal_ = 0.0;
  else
    mode_ = Mode::Hold;
}

hal::Result<> can_follow(const planner::Trajectory& trajectory, bool running, bool at_rest,
                         const hal::JointVector& commanded_rad, const SetpointLimits& limits) {
  constexpr const char* kWhere = "arm.follow";
  if (trajectory.empty()) return hal::failure(hal::ErrorCode::BadInput, kWhere, "the trajectory is empty");
  if (!running) return hal::failure(hal::ErrorCode::NotReady, kWhere, "the arm is not commanded yet");
  if (!at_rest)
    return hal::failure(hal::ErrorCode::NotReady, kWhere, "the arm is still moving; hold() first");
  int joint = 0;
  const double off = (commanded_rad - trajectory.start()).cwiseAbs().maxCoeff(&joint);
  if (!(off <= limits.start_tolerance_rad))
    return hal::failure(
        hal::ErrorCode::BadInput, kWhere,
        fmt::format("the trajectory starts {:.4f} rad from the commanded position in A{} (limit {:.4f})", off,
                    joint + 1, limits.start_tolerance_rad));
  return {};
}

hal::Result<> SetpointGenerator::follow(std::shared_ptr<const planner::Trajectory> trajectory) {
  if (!trajectory) return hal::failure(hal::ErrorCode::BadInput, "arm.follow", "there is no trajectory");
  if (auto can = can_follow(*trajectory, running_, at_rest(), q_, limits_); !can) return can;
  trajectory_ = std::move(trajectory);
  trajectory_offset_ = q_ - trajectory_->start();
  joined_s_ = 0.0;
  trajectory_s_ = 0.0;
  rate_ = rate_goal_ = 1.0;  // the trajectory itself starts at rest
  rate_slope_ = 0.0;
  mode_ = Mode::Trajectory;
  on_trajectory_ = along_ = true;
  cut_off_ = false;
  urgency_ = 1.0;
  tare_ = {palm_rise(*model_, q_), rest_tau_};
  if (std::exchange(first_since_start_, false)) first_tare_ = tare_;
  lag_at_start_ = rest_lag_;
  contact_ = first_contact_ = hal::Wrench{};
  armed_ = true;
  blocked_ = {};
  return {};
}

bool SetpointGenerator::resume(double speed) {
  return run_along(std::clamp(speed, 0.0, 1.0));
}

bool SetpointGenerator::back(double speed) {
  return run_along(-std::clamp(speed, 0.0, 1.0));
}

bool SetpointGenerator::run_along(double rate) {
  if (!on_trajectory_ && !rejoin()) return false;
  urgency_ = 1.0;
  mode_ = Mode::Trajectory;
  along_ = rate != 0.0;
  rate_goal_ = rate;
  blocked_ = {};
  armed_ = false;  // until it is quiet: the motion back from a contact begins in it
  return true;
}

bool SetpointGenerator::rejoin() {
  if (!cut_off_ || !running_ || !at_rest()) return false;
  // the arm came to rest by itself, not far from where it was when the trajectory was cut off
  double nearest_s = trajectory_s_, least = (q_ - trajectory_->sample(trajectory_s_).q_rad).squaredNorm();
  for (int i = -kRejoinSteps; i <= kRejoinSteps; ++i) {
    const double s = std::clamp(trajectory_s_ + kRejoin_s * i / kRejoinSteps, 0.0, trajectory_->duration_s());
    const double off = (q_ - trajectory_->sample(s).q_rad).squaredNorm();
    if (off >= least) continue;
    least = off;
    nearest_s = s;
  }
  const hal::JointVector off = q_ - trajectory_->sample(nearest_s).q_rad;
  if (!(off.cwiseAbs().maxCoeff() <= limits_.start_tolerance_rad)) return false;
  trajectory_s_ = nearest_s;
  trajectory_offset_ = off;
  joined_s_ = rate_ = rate_slope_ = 0.0;
  on_trajectory_ = true;
  cut_off_ = false;
  return true;
}

void SetpointGenerator::servo(const hal::JointVector& q_rad, const hal::JointVector& tau_superposed_nm) {
  if (!running_ || !q_rad.allFinite() || !tau_superposed_nm.allFinite()) return;
  if (mode_ != Mode::Servo) servo_before_ = q_rad;
  mode_ = Mode::Servo;
  on_trajectory_ = cut_off_ = along_ = false;
  servo_q_ = q_rad;
  superpose(tau_superposed_nm);
}

void SetpointGenerator::superpose(const hal::JointVector& tau_nm) {
  if (tau_nm.allFinite()) tau_goal_ = tau_nm.cwiseMax(-superposed_).cwiseMin(superposed_);
}

void SetpointGenerator::set_stiffness(double nm_rad, double slope_nm_rad_s) {
  if (std::isfinite(nm_rad)) stiffness_goal_ = std::max(0.0, nm_rad);
  stiffness_slope_ = slope_nm_rad_s > 0.0 ? slope_nm_rad_s : limits_.stiffness_slope_nm_rad_s;
}

hal::ImpedanceCommand SetpointGenerator::step(const hal::ArmState& state) {
  const double gap_s = time_.advance(state.measured_at);
  const bool usable = state.may_command && state.q_rad.allFinite();
  // with a long period of the arm a few of its cycles are no gap
  const double longest_s = std::max(limits_.gap_s, kGapCycles * time_.period_s());
  if (!usable || !running_ || std::abs(gap_s) > longest_s) {
    start_from(state, usable);
  } else if (gap_s > 0.0) {
    const double dt = time_.step_s();
    const hal::JointVector before = q_;
    set_pace(state.slow || asked_slow_, dt);
    if (mode_ == Mode::Trajectory)
      step_trajectory(dt);
    else if (mode_ == Mode::Servo)
      step_servo(dt);
    else
      step_hold(dt);
    dq_ = (q_ - before) / dt;
    const double part = stiffness_goal_ > stiffness_ ? stiffening_ : 1.0;
    stiffness_ = towards(stiffness_, stiffness_goal_, part * stiffness_slope_ * dt);
    for (int i = 0; i < hal::kArmJoints; ++i)
      tau_[i] = towards(tau_[i], tau_goal_[i], limits_.torque_slope_nm_s * dt);
    watch(state, gap_s);
  }
  hal::ImpedanceCommand command;
  command.q_rad = q_;
  command.stiffness_nm_rad.setConstant(stiffness_);
  command.tau_superposed_nm = tau_;
  return command;
}

void SetpointGenerator::start_from(const hal::ArmState& state, bool usable) {
  running_ = usable;
  if (usable) ++starts_;
  if (state.q_rad.allFinite()) q_ = state.q_rad;
  dq_.setZero();
  tau_.setZero();
  tau_goal_.setZero();
  mode_ = Mode::Hold;
  cut_off_ = cut_off_ || on_trajectory_;
  on_trajectory_ = false;
  if (state.tau_external_nm.allFinite()) rest_tau_ = state.tau_external_nm;
  rest_lag_.setZero();
  first_since_start_ = true;
}

void SetpointGenerator::set_pace(bool slow, double dt_s) {
  slow_left_s_ = slow ? limits_.slow_hold_s : std::max(0.0, slow_left_s_ - dt_s);
  const double goal = speed_goal();
  pace_ = towards(pace_, goal, (goal < pace_ ? limits_.stop_slope_1_s : limits_.slow_slope_1_s) * dt_s);
}

void SetpointGenerator::step_hold(double dt_s) {
  for (int i = 0; i < hal::kArmJoints; ++i)
    q_[i] += dt_s * hal::braking_velocity(
                        q_[i], dq_[i], dt_s,
                        bounds_of(lower_, upper_, velocity_, urgency_ * limits_.acceleration_rad_s2, i));
}

void SetpointGenerator::step_trajectory(double dt_s) {
  // The trajectory's own time runs with `rate_`. Its change is bounded so that trajectory and change together
  // keep the acceleration: |q'' r^2 + q' r'| <= a for every joint, with q' and q'' taken along the
  // trajectory.
  const planner::JointSample at = trajectory_->sample(trajectory_s_);
  const double goal = rate_goal_ * speed_goal();
  // stops are short, starts are gentle
  const bool faster = std::abs(goal) > std::abs(rate_) && goal * rate_ >= 0.0;
  const double acceleration = faster ? limits_.resume_rad_s2 : urgency_ * limits_.acceleration_rad_s2;
  const double joint_jerk = faster ? limits_.resume_rad_s3 : urgency_ * limits_.jerk_rad_s3;
  double least = -kRateSlope_s, most = kRateSlope_s, jerk = kRateJerk_s2;
  for (int i = 0; i < hal::kArmJoints; ++i) {
    const double v = std::abs(at.dq_rad_s[i]);
    if (v < 1e-6) continue;
    const double own = at.ddq_rad_s2[i] * rate_ * rate_ * (at.dq_rad_s[i] > 0.0 ? 1.0 : -1.0);
    least = std::max(least, std::min(0.0, (-acceleration - own) / v));
    most = std::min(most, std::max(0.0, (acceleration - own) / v));
    jerk = std::min(jerk, joint_jerk / v);
  }
  const double left = goal - rate_;
  // the slope that can still be taken back until the goal is reached
  const double wanted = std::copysign(std::sqrt(2.0 * jerk * std::abs(left)), left);
  rate_slope_ = std::clamp(towards(rate_slope_, wanted, jerk * dt_s), least, most);
  if (std::abs(left) <= std::abs(rate_slope_) * dt_s || left == 0.0) {
    rate_ = goal;
    rate_slope_ = 0.0;
  } else {
    rate_ += rate_slope_ * dt_s;
  }
  trajectory_s_ = std::clamp(trajectory_s_ + rate_ * dt_s, 0.0, trajectory_->duration_s());
  joined_s_ += dt_s;
  q_ =
      trajectory_->sample(trajectory_s_).q_rad + offset_left(joined_s_, limits_.blend_s) * trajectory_offset_;
  if (joined_s_ < limits_.blend_s && !trajectory_offset_.isZero()) return;
  if (const double end = rate_goal_ > 0.0 ? trajectory_->duration_s() : 0.0;
      rate_goal_ != 0.0 && trajectory_s_ == end) {
    rate_ = rate_slope_ = 0.0;  // the trajectory itself is at rest at its ends
    mode_ = Mode::Hold;
  }
}

void SetpointGenerator::step_servo(double dt_s) {
  for (int i = 0; i < hal::kArmJoints; ++i) {
    const hal::JointBounds b =
        bounds_of(lower_, upper_, velocity_, urgency_ * limits_.acceleration_rad_s2, i);
    // velocity of the set point itself; one that jumps has none
    double w = (servo_q_[i] - servo_before_[i]) / dt_s;
    if (std::abs(w) > b.velocity_rad_s) w = 0.0;
    const double off = servo_q_[i] - q_[i] - w * dt_s;
    const double near =
        std::min(std::abs(off) / dt_s, hal::stoppable_speed(std::abs(off), dt_s, b.acceleration_rad_s2));
    const hal::VelocityRange allowed = hal::allowed_velocity(q_[i], dq_[i], dt_s, b);
    q_[i] += dt_s * std::clamp(w + std::copysign(near, off), allowed.low, allowed.high);
  }
  servo_before_ = servo_q_;
}

void SetpointGenerator::watch(const hal::ArmState& state, double dt_s) {
  if (!state.tau_external_nm.allFinite()) return;
  const hal::JointVector lag = q_ - state.q_rad;
  const bool rests = mode_ != Mode::Trajectory && at_rest();
  rested_s_ = rests ? rested_s_ + dt_s : 0.0;
  if (rests) {
    // a mean at first: what was felt before the last motion says nothing here
    const double part = std::min(1.0, dt_s / std::min(rested_s_, limits_.rest_filter_s));
    rest_tau_ += part * (state.tau_external_nm - rest_tau_);
    rest_lag_ += part * (lag - rest_lag_);
  }
  if (mode_ != Mode::Trajectory) return;

  const auto felt = [&](const Tare& tare) {
    return contact_wrench(*model_, state.q_rad, tare.rise_m, state.tau_external_nm - tare.tau_nm,
                          {limits_.torque_error_nm, limits_.tool_error_kg});
  };
  const hal::Wrench now = felt(tare_), first = felt(first_tare_);
  const double part = limits_.contact_filter_s > 0.0 ? 1.0 - std::exp(-dt_s / limits_.contact_filter_s) : 1.0;
  contact_.force += part * (now.force - contact_.force);
  first_contact_.force += part * (first.force - first_contact_.force);
  const double force = contact_force_n();
  int joint = 0;
  const double lag_rad = (lag - lag_at_start_).cwiseAbs().maxCoeff(&joint);
  const bool quiet = force < limits_.rearm_fraction * contact_limit_n_ &&
                     lag_rad < limits_.rearm_fraction * limits_.follow_error_rad;
  armed_ = armed_ || quiet;
  if (!armed_ || blocked()) return;
  Contact why = Contact::None;
  if (force > contact_limit_n_)
    why = Contact::Force;
  else if (lag_rad > limits_.follow_error_rad)
    why = Contact::Lag;
  if (why != Contact::None)
    blocked_ = {why, force, contact_limit_n_, joint, lag_rad, limits_.follow_error_rad};
}

double SetpointGenerator::contact_force_n() const {
  return std::min(contact_.force.norm(), first_contact_.force.norm());
}

bool SetpointGenerator::at_rest() const {
  return dq_.cwiseAbs().maxCoeff() < kAtRest_rad_s;
}

bool SetpointGenerator::done() const {
  if (!running_ || !at_rest() || (cut_off_ && along_)) return false;
  if (mode_ == Mode::Servo) return (servo_q_ - q_).cwiseAbs().maxCoeff() < 1e-6;
  return mode_ == Mode::Hold || (rate_goal_ == 0.0 && rate_ == 0.0);
}

double SetpointGenerator::progress() const {
  if (!(on_trajectory_ || cut_off_) || trajectory_->duration_s() <= 0.0) return 1.0;
  return trajectory_s_ / trajectory_->duration_s();
}

std::string describe(const SetpointGenerator::Blockage& b) {
  using Contact = SetpointGenerator::Contact;
  if (b.why == Contact::Force)
    return fmt::format("unexpected contact: {:.0f} N (limit {:.0f} N)", b.force_n, b.force_limit_n);
  if (b.why == Contact::Lag)
    return fmt::format("A{} does not follow: {:.3f} rad behind (limit {:.3f} rad)", b.joint + 1, b.lag_rad,
                       b.lag_limit_rad);
  return {};
}

}  // namespace colift::control
