#include "control/task/object_monitor.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "control/task/grip_quality.hpp"
#include "hal/types/units.hpp"
#include "perception/motion/pipe_tilt.hpp"

namespace colift::control {
namespace {

// Where the view does not hold it, his end's place jumps from frame to frame between two that fit. What is
// larger than the largest jump of the last seconds is a motion. A fall is no jump until some frames later,
// and the largest one may be one, so that it counts only so far.
constexpr double kMotion_jumps = 1.3, kRemembered = 0.99, kMaxJump_m = 0.015;
constexpr double kMinShare = 0.05;  // with less, the robot's load says nothing of the partner's

// The joint with the least angle left to one of its limits, in words.
std::string nearest_limit(const hal::RobotModel& model, const hal::JointVector& q_rad) {
  const hal::JointVector to_lower = q_rad - model.lower_rad(), to_upper = model.upper_rad() - q_rad;
  Eigen::Index joint = 0;
  const double left_rad = to_lower.cwiseMin(to_upper).minCoeff(&joint);
  return fmt::format("A{} is {:.1f} deg from its limit", joint + 1, hal::rad_to_deg(left_rad));
}

}  // namespace

void ObjectMonitor::set_grip() {
  X_WH_grip_ = c_.palm();
  if (!c_.record.decision) return;
  const hal::Pose X = motion_ ? motion_->X_WTnow_WTref : hal::Pose::Identity();
  pivot_ref_W_ = X.inverse() * (X_WH_grip_ * c_.hand_line().pivot_H);
}

std::optional<perception::HeldPoint> ObjectMonitor::held_point() const {
  const bool carries = c_.state == Task::AwaitReady || c_.state == Task::TestLift || c_.state == Task::Lift ||
                       c_.state == Task::Hold || c_.state == Task::Lower || c_.state == Task::Pause;
  if (!carries || !c_.readings.hand.held || !c_.record.decision) return std::nullopt;
  return perception::HeldPoint{pivot_ref_W_, c_.palm() * c_.hand_line().pivot_H};
}

void ObjectMonitor::start_lift() {
  set_grip();
  partner_top_m_ = 0.0;
  hanging_tilt_rad_ = NAN;
  partner_bears_at_ = c_.now;
}

bool ObjectMonitor::seen_down() const {
  const double tolerance_m = c_.config.task.carry.standing_tolerance_m;
  if (!motion_) return c_.arm.view().height_m < tolerance_m;
  return std::abs(motion_->rise(X_WH_grip_.translation(), hal::Vec3::UnitZ())) < tolerance_m &&
         partner_rise_m_ < tolerance_m;
}

bool ObjectMonitor::seen_standing() const {
  return seen_down() || (c_.arm.blocked() && seen_askew());
}

bool ObjectMonitor::seen_askew() const {
  const CarryConfig& carry = c_.config.task.carry;
  // what was level in the air and is tilted now lies on something
  constexpr double kMinHanging_rad = hal::deg_to_rad(1.5), kTiltNoise_rad = hal::deg_to_rad(0.5);
  if (!motion_ || !(hanging_tilt_rad_ >= kMinHanging_rad)) return false;
  if (!(tilt_rad_ <= std::min(hanging_tilt_rad_ + kTiltNoise_rad, hal::deg_to_rad(carry.max_askew_deg))))
    return false;
  const hal::OrientedBox& box = c_.session.analysis().scene.target->shape;
  double lowest_m = std::numeric_limits<double>::infinity();
  for (int corner = 0; corner < 8; ++corner) {
    const hal::Vec3 half(corner & 1 ? 0.5 : -0.5, corner & 2 ? 0.5 : -0.5, corner & 4 ? 0.5 : -0.5);
    const hal::Vec3 at = box.center + box.axes * half.cwiseProduct(box.size);
    lowest_m = std::min(lowest_m, motion_->rise(at, hal::Vec3::UnitZ()));
  }
  return std::abs(lowest_m) < carry.standing_tolerance_m &&
         partner_rise_m_ < 2.0 * carry.standing_tolerance_m;
}

// Nobody measures his force. Where the mass was not known before the lift, what he bears follows from the
// load in the hand and the robot's share, which a plain lift tells no better than the prediction does
// (docs/decisions/0015). Not from the lower end of the share's interval: of light ladders, of which it is
// said to be 9 to 64 %, that would make 400 N.
double ObjectMonitor::partner_load_n() const {
  const Outcome& outcome = *c_.record.decision;
  const double share = outcome.decision.share;
  if (outcome.share.mass_kg || share <= kMinShare) return 0.0;
  return c_.arm.view().load_n * (1.0 / share - 1.0);
}

void ObjectMonitor::update() {
  if (c_.record.decision && partner_load_n() <= c_.config.decision.partner_load_n) partner_bears_at_ = c_.now;
  if (!c_.readings.frame) return;
  motion_ = c_.session.watch_object(*c_.readings.frame, c_.posture(), held_point());
  const hal::Vec3 up = hal::Vec3::UnitZ();
  LiftSample sample;
  sample.t_s = hal::seconds(c_.now - c_.began);
  sample.state = c_.state;
  const hal::Pose X_WH = c_.palm();
  sample.palm_height_m = X_WH.translation().z() - X_WH_grip_.translation().z();
  sample.load_n = c_.arm.view().load_n;
  sample.palm_W = X_WH.translation();
  if (const auto& wrench_W = c_.arm.view().wrench_W) sample.wrench_W = *wrench_W;
  sample.object_rise_m = sample.tilt_rad = sample.slip_m = NAN;
  if (motion_) {
    const hal::Vec3 grip = X_WH_grip_.translation();
    partner_rise_m_ = motion_->rise(c_.record.decision->partner->position, up);
    partner_top_m_ = std::max(partner_top_m_, partner_rise_m_);
    update_noise(sample.palm_height_m - partner_rise_m_);
    const double first_m = std::max(c_.config.task.lift.leader_rise_m, end_noise_m());
    frames_first_ = partner_rise_m_ - sample.palm_height_m > first_m ? frames_first_ + 1 : 0;
    const auto axis = perception::pipe_axis(c_.session.analysis().scene);
    tilt_rad_ = axis ? perception::slope_change(motion_->X_WTnow_WTref, *axis, up) : motion_->tilt(up);
    if (c_.state == Task::TestLift || c_.state == Task::Lift || c_.state == Task::Hold)
      hanging_tilt_rad_ = tilt_rad_;
    // along the lift: across it a flat or round object may not show how far it went
    slip_m_ = std::abs(motion_->rise(grip, up) - (X_WH.translation() - grip).dot(up));
    sample.object_rise_m = motion_->rise(c_.session.analysis().scene.target->cog, up);
    sample.tilt_rad = tilt_rad_;
    sample.slip_m = slip_m_;
    sample.X_WTnow_WTref = motion_->X_WTnow_WTref;
    c_.see_object(motion_->X_WTnow_WTref);
    c_.arm.see_partner(partner_rise_m_);
    frames_tilting_ = hal::rad_to_deg(tilt_rad_) > c_.config.task.max_tilt_deg ? frames_tilting_ + 1 : 0;
    frames_slipping_ = slip_m_ > c_.config.task.max_slip_m ? frames_slipping_ + 1 : 0;
  }
  c_.record.curve.push_back(sample);
  order_ = {};
  if (c_.options.policies.carry && (c_.state == Task::Lift || c_.state == Task::Hold))
    order_ = c_.options.policies.carry(sample);
  c_.carry_scale = std::clamp(std::isnan(order_.speed_scale) ? 1.0 : order_.speed_scale, 0.0, 1.0);
}

void ObjectMonitor::update_noise(double lag_m) {
  std::shift_right(lags_m_.begin(), lags_m_.end(), 1);
  lags_m_.front() = lag_m;
  // against the mean of its neighbours, doubled: a steady motion is no jump
  const std::size_t n = lags_m_.size();
  const double jump_m = lags_m_[n - 3] - 2.0 * lags_m_[n - 2] + lags_m_[n - 1];
  if (std::isnan(jump_m)) return;
  jump_m_ = std::max(std::min(std::abs(jump_m), kMaxJump_m), kRemembered * jump_m_);
}

double ObjectMonitor::end_noise_m() const {
  return kMotion_jumps * jump_m_;
}

bool ObjectMonitor::partner_lifts_first() const {
  return frames_first_ >= c_.config.task.carry.limit_frames;
}

std::optional<TaskEvent> ObjectMonitor::beyond_limits() const {
  const hal::HandState& hand = c_.readings.hand;
  const TaskConfig& task = c_.config.task;
  if (!hand.held) return TaskEvent{Event::HandEmpty, "the hand has lost the object"};
  // it has gripped up by itself already
  if (hand.slips) return TaskEvent{Event::HandUnfit, slip_words(hand)};
  if (hand.hot) return TaskEvent{Event::HandUnfit, hand.warning.str()};
  if (frames_tilting_ >= task.carry.limit_frames)
    return TaskEvent{Event::LimitReached, fmt::format("the object tilts by {:.1f} deg (limit {:.1f})",
                                                      hal::rad_to_deg(tilt_rad_), task.max_tilt_deg)};
  if (frames_slipping_ >= task.carry.limit_frames)
    return TaskEvent{Event::LimitReached, fmt::format("the object slips {:.0f} mm in the hand (limit {:.0f})",
                                                      1e3 * slip_m_, 1e3 * task.max_slip_m)};
  if (const double load_n = c_.arm.view().load_n; load_n > task.max_load_n)
    return TaskEvent{Event::LimitReached, fmt::format("the load of {:.0f} N is above the limit of {:.0f} N",
                                                      load_n, task.max_load_n)};
  if (const double left_j = c_.arm.view().energy_j; left_j <= 0.0)
    return TaskEvent{Event::LimitReached,
                     fmt::format("the arm has put {:.1f} J into the object and whoever holds it, all that a "
                                 "lift may take",
                                 task.max_load_n * task.lift_height_m + task.lift.energy_margin_j - left_j)};
  if (hal::seconds(c_.now - partner_bears_at_) > task.carry.settle_s) {
    const Outcome& outcome = *c_.record.decision;
    const auto& interval = outcome.share.interval;
    const std::string known =
        interval ? fmt::format("{:.0f} to {:.0f} %", 1e2 * interval->low, 1e2 * interval->high) : "unknown";
    return TaskEvent{
        Event::LimitReached,
        fmt::format("the partner bears about {:.0f} N (limit {:.0f} N), if the robot's {:.0f} N are "
                    "the predicted share of {:.0f} % ({})",
                    partner_load_n(), c_.config.decision.partner_load_n, c_.arm.view().load_n,
                    1e2 * outcome.decision.share, known)};
  }
  return std::nullopt;
}

std::optional<TaskEvent> ObjectMonitor::end_of_reach() const {
  if (!c_.arm.end_of_reach()) return std::nullopt;
  return TaskEvent{Event::EndOfReach, fmt::format("{:.1f} cm up, the palm cannot continue straight: {}",
                                                  1e2 * c_.arm.view().height_m,
                                                  nearest_limit(c_.rig.model, c_.arm.commanded()))};
}

double ObjectMonitor::displacement_m() const {
  if (!motion_) return 0.0;
  double max_m = 0.0;
  // a rotation shows at the corners
  const hal::OrientedBox& box = c_.session.analysis().scene.target->obb;
  for (int corner = 0; corner < 8; ++corner) {
    const hal::Vec3 half(corner & 1 ? 0.5 : -0.5, corner & 2 ? 0.5 : -0.5, corner & 4 ? 0.5 : -0.5);
    const hal::Vec3 p = box.center + box.axes * box.size.cwiseProduct(half);
    max_m = std::max(max_m, (motion_->X_WTnow_WTref * p - p).norm());
  }
  return max_m;
}

}  // namespace colift::control
