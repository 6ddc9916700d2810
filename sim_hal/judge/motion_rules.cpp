#include "sim_hal/judge/motion_rules.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace colift::sim_hal {
namespace {

constexpr double kAcceleration_rad_s2 = 15.0;  // of commands: what the arm's guard lets pass at most
constexpr double kTolerance = 1.02, kFirstStep_rad = 0.01;
constexpr double kGapCycles = 5.5, kAlike_s = 0.0005;
constexpr double kBraking_s = 0.5, kMoved_rad = 0.02;   // after a stop
constexpr double kSwings_s = 1.0, kDrifts_rad_s = 0.1;  // of an arm that was pushed
// 30 N is where a contact has to be noticed; half as much again for what an estimate of it may lack
constexpr double kPush_n = 45.0, kMoves_rad_s = 0.05, kNotice_s = 0.010, kStop_s = 0.5, kSlower = 0.01;
// Commands that follow a push take energy out of the arm: 4.5 N m of a soft joint at 0.05 rad/s 2 mJ in 10
// ms. 45 N against a surface that moves at 1 cm/s are half a watt.
constexpr double kTakes_j = 0.0002, kDrives_w = 0.5, kLate_s = 0.1;

bool touched(const TickReport& report) {
  // the robot, or what it holds
  return report.pushed ||
         std::any_of(report.contacts.begin(), report.contacts.end(), [&](const BodyContact& c) {
           return c.by == BodyContact::By::Robot ||
                  (c.by == BodyContact::By::Object && report.truth.robot_touches_object);
         });
}

}  // namespace

MotionRules::MotionRules(const hal::RobotModel& model, bool exact_time)
    : lower_(model.lower_rad()),
      upper_(model.upper_rad()),
      velocity_(model.velocity_rad_s()),
      exact_time_(exact_time) {}

void MotionRules::breach(const char* rule, std::string what, std::vector<std::string>& breaches) {
  if (std::find(broken_.begin(), broken_.end(), rule) != broken_.end()) return;
  broken_.emplace_back(rule);
  breaches.push_back(fmt::format("{}: {}", rule, what));
}

void MotionRules::command(const TickReport& r, std::vector<std::string>& breaches) {
  for (int a = 0; a < hal::kArmJoints; ++a) {
    if (!std::isfinite(r.command_rad[a]) || r.command_rad[a] < lower_[a] || r.command_rad[a] > upper_[a])
      breach("I1",
             fmt::format("A{} commanded to {:.4f} rad at {:.3f} s, limits {:.4f} to {:.4f}", a + 1,
                         r.command_rad[a], r.t_s, lower_[a], upper_[a]),
             breaches);
  }
  // After more than five missing cycles the arm has come to rest: the next command is a first one, from where
  // it is. Over a shorter gap its controller moves on as before, and what was missed is to be made up for by
  // nobody: a step counts for one regular cycle, however late it comes. Made up for, it is a speed of its
  // own.
  if (commanded_s_ && cycle_s_ && r.t_s - *commanded_s_ > kGapCycles * *cycle_s_) commanded_s_.reset();
  const hal::JointVector before = commanded_s_ ? command_rad_ : r.truth.q_rad;
  const double since = commanded_s_ ? r.t_s - *commanded_s_ : 0.0;
  if (since > 0.0 && std::abs(since - since_s_) < kAlike_s) cycle_s_ = since;
  since_s_ = since;
  const double dt = cycle_s_ ? std::min(since, *cycle_s_) : since;
  const hal::JointVector step = r.command_rad - before;
  const hal::JointVector speed = dt > 0.0 ? hal::JointVector(step / dt) : hal::JointVector::Zero();
  for (int a = 0; a < hal::kArmJoints && exact_time_; ++a) {
    if (!commanded_s_ && std::abs(step[a]) > kFirstStep_rad)
      breach("I2",
             fmt::format("first command of A{} is {:.4f} rad from the measured position at {:.3f} s", a + 1,
                         step[a], r.t_s),
             breaches);
    if (std::abs(speed[a]) > kTolerance * velocity_[a])
      breach("I2",
             fmt::format("A{} commanded at {:.2f} rad/s at {:.3f} s (limit {:.2f})", a + 1, speed[a], r.t_s,
                         velocity_[a]),
             breaches);
    const double change = dt > 0.0 ? std::abs(speed[a] - command_rad_s_[a]) / dt : 0.0;
    if (change > kTolerance * kAcceleration_rad_s2)
      breach("I2",
             fmt::format("A{} accelerated at {:.1f} rad/s2 at {:.3f} s (limit {:.0f})", a + 1, change, r.t_s,
                         kAcceleration_rad_s2),
             breaches);
  }
  commanded_s_ = r.t_s;
  command_rad_ = r.command_rad;
  command_rad_s_ = speed;
}

void MotionRules::standstill(const TickReport& r, bool stopped, std::vector<std::string>& breaches) {
  if (!stopped) {
    stopped_s_.reset();
    rests_at_.reset();
    return;
  }
  if (!stopped_s_) stopped_s_ = r.t_s;
  if (r.t_s - *stopped_s_ < kBraking_s) return;
  // a person may push a soft arm away, and what he pushed may brake as after a stop
  if (touched(r)) touched_s_ = r.t_s;
  if (!rests_at_ || r.t_s - touched_s_ < kBraking_s) rests_at_ = command_rad_;
  const double moved = (command_rad_ - *rests_at_).cwiseAbs().maxCoeff();
  if (moved > kMoved_rad)
    breach("I5", fmt::format("commanded {:.3f} rad away after the stop at {:.3f} s", moved, *stopped_s_),
           breaches);
}

// A soft arm swings out after a push. What still moves it when nobody and nothing touches it is its own
// torque.
void MotionRules::drift(const TickReport& r, Said said, std::vector<std::string>& breaches) {
  if (said == Said::Works || touched(r) || r.truth.robot_touches_object) moved_s_ = r.t_s;
  const double speed = r.dq_rad_s.cwiseAbs().maxCoeff();
  if (r.t_s - moved_s_ > kSwings_s && speed > kDrifts_rad_s)
    breach("I5",
           fmt::format("the arm still moves at {:.2f} rad/s at {:.3f} s, {:.1f} s after anything touched it",
                       speed, r.t_s, r.t_s - moved_s_),
           breaches);
}

// A command that follows whoever pushes the arm takes energy out of it; one that drives on puts energy in.
void MotionRules::push(const TickReport& r, double commanded_j, std::vector<std::string>& breaches) {
  Vec3 sum = Vec3::Zero();
  for (const BodyContact& c : r.contacts)
    if (c.by == BodyContact::By::Robot) sum += c.force_W;
  const double force_n = sum.norm(), speed = command_rad_s_.norm();
  if (!pushed_s_) {
    if (force_n < kPush_n || speed < kMoves_rad_s) return;
    pushed_s_ = r.t_s;
    pushed_rad_s_ = speed;
    pushed_j_ = commanded_j;
    late_j_.reset();
    brakes_ = false;
  }
  const double since = r.t_s - *pushed_s_;
  if (!brakes_ && (speed < (1.0 - kSlower) * pushed_rad_s_ || commanded_j - pushed_j_ < -kTakes_j)) {
    brakes_ = true;
    latency_s_ = std::max(latency_s_.value_or(0.0), since);
  }
  if (!brakes_ && since > kNotice_s)
    breach("I10",
           fmt::format("{:.0f} N of a person at {:.3f} s, and no slower command within 10 ms", force_n,
                       *pushed_s_),
           breaches);
  if (since >= kStop_s - kLate_s && !late_j_) late_j_ = commanded_j;
  if (since < kStop_s) return;
  if (speed > kMoves_rad_s && force_n > kPush_n && commanded_j - *late_j_ > kDrives_w * kLate_s)
    breach("I10",
           fmt::format("still commanded at {:.2f} rad/s {:.1f} s after a person's push at {:.3f} s", speed,
                       since, *pushed_s_),
           breaches);
  pushed_s_.reset();
}

void MotionRules::tick(const TickReport& report, Said said, double commanded_j,
                       std::vector<std::string>& breaches) {
  if (report.commanded) command(report, breaches);
  standstill(report, said == Said::Stopped, breaches);
  drift(report, said, breaches);
  if (exact_time_) push(report, commanded_j, breaches);
}

}  // namespace colift::sim_hal
