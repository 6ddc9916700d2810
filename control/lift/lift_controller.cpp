#include "control/lift/lift_controller.hpp"

#include <algorithm>
#include <cmath>

#include "hal/types/units.hpp"

namespace colift::control {
namespace {

constexpr double kLargestStep_rad = 0.05;                 // in one cycle; more is a jump to another posture
constexpr double kMaxAside_m = 0.1, kMaxAside_rad = 0.4;  // of a palm that was taken aside while it carried
constexpr double kAtRest_m = 0.002;   // and m/s: the camera sees the partner's end no finer
constexpr double kMinSpan = 0.25;     // of the time of a whole lift: for what is left of one
constexpr double kMinPath_m = 0.001;  // against division by no height

// height along a minimum-jerk profile from 0 to 1
double minimum_jerk(double s) {
  const double x = std::clamp(s, 0.0, 1.0);
  return x * x * x * (10.0 + x * (-15.0 + 6.0 * x));
}

}  // namespace

LiftController::LiftController(const hal::RobotModel& model, const planner::ArmGeometry& arm,
                               const TaskConfig& config)
    : model_(&model), arm_(arm), config_(config), compliance_(config.lift.tilt_compliance) {}

void LiftController::start(const hal::JointVector& q_commanded_rad, const HandLine& line) {
  q_rad_ = q_commanded_rad;
  X_WF0_ = planner::flange_pose(arm_, q_commanded_rad);
  X_FH_ = X_WF0_.inverse() * hal::hand_pose(*model_, q_commanded_rad);
  line_ = line;
  compliance_.start(line_);
  height_m_ = speed_m_s_ = from_m_ = to_m_ = time_s_ = span_s_ = s_per_m_ = partner_rise_m_ = 0.0;
  fed_ = {};
}

void LiftController::give_way(const HandLine& line) {
  if (!line_.along_W.isZero() || line.along_W.isZero()) return;
  line_ = line;
  compliance_.start(line_);
}

void LiftController::aim(double to_m, double time_s) {
  at_end_ = false;
  from_m_ = height_m_;
  to_m_ = to_m;
  time_s_ = 0.0;
  span_s_ = time_s;
  s_per_m_ = time_s / std::max(std::abs(to_m_ - from_m_), kMinPath_m);
}

void LiftController::lift(Role role, double height_m, double time_s) {
  role_ = role;
  aim(height_m, time_s);
}

void LiftController::stay() {
  aim(height_m_, 0.0);
  role_ = Role::Lead;
}

void LiftController::lower() {
  // who followed up follows down; but the ground is reached in any case
  aim(0.0, config_.lift_s);
  role_ = Role::Lead;
}

void LiftController::restart(const hal::JointVector& q_commanded_rad) {
  const double floor_m = X_WF0_.translation().z();
  q_rad_ = q_commanded_rad;
  X_WF0_ = planner::flange_pose(arm_, q_commanded_rad);
  height_m_ = X_WF0_.translation().z() - floor_m;
  X_WF0_.translation().z() = floor_m;
  compliance_.start(line_);
  speed_m_s_ = 0.0;
  aim(to_m_, std::max(std::abs(to_m_ - height_m_) * s_per_m_, kMinSpan * config_.lift_s));
}

hal::JointVector LiftController::where_taken(const hal::JointVector& q_commanded_rad,
                                             const hal::JointVector& q_measured_rad) const {
  const hal::Pose X_WF_commanded = planner::flange_pose(arm_, q_commanded_rad);
  hal::Pose X_WF = planner::flange_pose(arm_, q_measured_rad);
  if (!((X_WF.translation() - X_WF_commanded.translation()).norm() <= kMaxAside_m)) return q_commanded_rad;
  // a palm that leans on the object would fall by as much as the fingers give way
  X_WF.translation().z() = std::max(X_WF.translation().z(), X_WF_commanded.translation().z());
  return planner::follow_ik(arm_, X_WF, q_commanded_rad, hal::deg_to_rad(config_.limit_margin_deg),
                            kMaxAside_rad)
      .value_or(q_commanded_rad);
}

double LiftController::next_height(double dt_s) {
  if (role_ == Role::Lead) {
    time_s_ = std::min(time_s_ + dt_s, span_s_);
    return from_m_ + (to_m_ - from_m_) * minimum_jerk(span_s_ > 0.0 ? time_s_ / span_s_ : 1.0);
  }
  const double goal = std::clamp(partner_rise_m_, 0.0, to_m_);
  const LiftMotionConfig& lift = config_.lift;
  const double wanted =
      std::clamp(lift.follow_gain_1_s * (goal - height_m_), -lift.follow_speed_m_s, lift.follow_speed_m_s);
  const double change = lift.follow_acceleration_m_s2 * dt_s;
  speed_m_s_ += std::clamp(wanted - speed_m_s_, -change, change);
  return height_m_ + speed_m_s_ * dt_s;
}

bool LiftController::at_rest() const {
  if (role_ == Role::Lead) return time_s_ >= span_s_;
  return std::abs(to_m_ - height_m_) < kAtRest_m && std::abs(speed_m_s_) < kAtRest_m;
}

hal::Pose LiftController::compliant(const hal::Pose& X_WF) const {
  return compliance_.motion(X_WF * (X_FH_ * line_.pivot_H)) * X_WF;
}

std::optional<LiftController::Command> LiftController::step(double dt_s,
                                                            const std::optional<hal::Wrench>& measured,
                                                            double pace) {
  if (at_end_) return std::nullopt;
  const double before_m = height_m_;
  height_m_ = next_height(pace * dt_s);
  hal::Pose X_WF = X_WF0_;
  X_WF.translation().z() += height_m_;
  // an arm that stands still for somebody does not turn either
  if (measured) compliance_.update(pace * dt_s, *measured, compliant(X_WF) * X_FH_);
  X_WF = compliant(X_WF);
  const auto q =
      planner::follow_ik(arm_, X_WF, q_rad_, hal::deg_to_rad(config_.limit_margin_deg), kLargestStep_rad);
  if (!q) {
    height_m_ = before_m;  // the way down begins here
    at_end_ = true;        // what lies behind may be in reach again, but not by the way that the palm goes
    return std::nullopt;
  }
  q_rad_ = *q;

  if (measured) {
    // sideways the arm stays as soft as its impedance: that is the partner's freedom. What pushes up is the
    // ground under the object: fed forward, it would be pressed down ever harder
    hal::Wrench borne;
    borne.force.z() = std::clamp(measured->force.z(), -config_.max_load_n, 0.0);
    if (borne.force.z() < 0.0) borne.torque = measured->torque;
    const double a = dt_s / (config_.lift.feed_forward_filter_s + dt_s);
    fed_.force += a * (borne.force - fed_.force);
    fed_.torque += a * (borne.torque - fed_.torque);
  }
  Command command;
  command.q_rad = q_rad_;
  Eigen::Matrix<double, 6, 1> wrench;
  wrench << fed_.force, fed_.torque;
  command.tau_superposed_nm = -(hal::jacobian(*model_, q_rad_, hal::Vec3::Zero()).transpose() * wrench);
  return command;
}

}  // namespace colift::control
