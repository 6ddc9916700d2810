#include "control/task/phases/retreat_phase.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <vector>

namespace colift::control {
namespace {

constexpr int kMaxUnloadings = 3;  // of one release, when the object is raised again and again
constexpr int kMaxContacts = 3;    // after which a retreat is no object's doing

}  // namespace

void RetreatPhase::begin_release() {
  unloadings_ = 0;
  if (!is_supported()) return start_unloading();
  // fingers that still answer are opened while they do
  if (c_.readings.without_puck) return open();
  proceed(Opening::Announced);
  (void)open_when_announced();
}

void RetreatPhase::proceed(Opening to) {
  opening_ = to;
  c_.sets_down = to == Opening::Unloading;
  c_.since = c_.now;
  c_.waited_s = 0.0;
}

void RetreatPhase::start_unloading() {
  ++unloadings_;
  unsupported_at_ = c_.now;
  // what a closing hand has lifted by millimetres is set down again before it opens
  proceed(Opening::Unloading);
  const CarryConfig& carry = c_.config.task.carry;
  c_.arm.start_lift(LiftController::Role::Lead, -carry.seek_m, carry.seek_m / carry.seek_speed_m_s);
}

bool RetreatPhase::is_supported() const {
  const ArmView& arm = c_.arm.view();
  if (!c_.readings.hand.held) return true;  // nothing is in it
  const CarryConfig& carry = c_.config.task.carry;
  const double carried_n = c_.record.lift ? c_.record.lift->load_n : 0.0;
  const double limit_n = std::max(carry.standing_load_n, carry.standing_load_fraction * carried_n);
  const double sideways_n = arm.wrench_W ? arm.wrench_W->force.head<2>().norm() : 0.0;
  return arm.load_n <= limit_n && sideways_n <= carry.max_release_force_n;
}

std::optional<TaskEvent> RetreatPhase::unload() {
  const CarryConfig& carry = c_.config.task.carry;
  c_.doing = "sets the object down before the hand opens";
  if (!is_supported()) unsupported_at_ = c_.now;
  if (hal::seconds(c_.now - unsupported_at_) >= carry.settle_s) {
    proceed(Opening::Announced);
    return std::nullopt;
  }
  const double unloading_s = c_.in_state_s();
  const double enough_s = carry.seek_m / carry.seek_speed_m_s + 2.0 * carry.settle_s;
  // whatever slows the arm: this has an end
  if (unloading_s > enough_s + c_.config.monitor.max_wait_s) return still_loaded();
  if (!c_.arm.lift_at_rest() && !c_.arm.end_of_reach()) return std::nullopt;
  if (unloading_s < enough_s) return std::nullopt;
  return still_loaded();
}

TaskEvent RetreatPhase::still_loaded() const {
  const CarryConfig& carry = c_.config.task.carry;
  const ArmView& arm = c_.arm.view();
  const double sideways_n = arm.wrench_W ? arm.wrench_W->force.head<2>().norm() : 0.0;
  return TaskEvent{Event::StillLoaded,
                   fmt::format("it carries {:.0f} N (limit {:.0f}), {:.0f} N pull sideways (limit {:.0f})",
                               arm.load_n, carry.standing_load_n, sideways_n, carry.max_release_force_n)};
}

std::optional<TaskEvent> RetreatPhase::open_when_announced() {
  c_.doing = "announces that the hand opens";
  if (!c_.may_begin(Motion::Open)) return std::nullopt;
  if (is_supported()) {
    open();
    return std::nullopt;
  }
  // it was raised again meanwhile
  if (unloadings_ >= kMaxUnloadings) return still_loaded();
  start_unloading();
  return std::nullopt;
}

void RetreatPhase::open() {
  proceed(Opening::Opening);
  c_.arm.hold();
  c_.arm.unload();
  if (const auto opening = c_.robot.hand->release(); !opening) c_.note_device("hand", opening.error().text());
}

std::optional<TaskEvent> RetreatPhase::release() {
  const hal::HandState& hand = c_.readings.hand;
  const auto& without_puck = c_.readings.without_puck;
  if (opening_ == Opening::Unloading) return unload();
  if (opening_ == Opening::Announced) return open_when_announced();
  c_.doing = "the fingers open";
  const bool may_leave = c_.may_begin(Motion::Retreat);
  if (c_.in_state_s() > c_.config.task.grip.hand_timeout_s)
    return TaskEvent{Event::TimeOut, "the hand does not open"};
  if (hand.moving || hand.held || c_.in_state_s() < c_.config.task.grip.command_shows_s) return std::nullopt;
  // a finger that stayed around the object would drag it along; of one that does not answer nobody knows
  bool open = true;
  for (std::size_t f = 0; f < hand.finger_rad.size(); ++f)
    open = open && (hand.finger_rad[f] < c_.config.task.grip.open_tolerance_rad || f == without_puck);
  if (!open || !may_leave) return std::nullopt;
  return TaskEvent{Event::HandOpen, without_puck ? "as far as it answers" : ""};
}

void RetreatPhase::begin_retreat(bool after_contact) {
  contacts_ = after_contact ? contacts_ + 1 : 0;
  leg_ = Leg::FromObject;
  // from where the arm is commanded now, which is the grasp but for what lift and lowering left over
  std::vector<hal::JointVector> points{c_.arm.commanded()};
  const planner::Trajectory& planned = c_.record.plan->retreat;
  const double s = planned.duration_s();
  constexpr int kPoints = 12;
  const auto off_rad = [&](int i) { return (planned.sample(s * i / kPoints).q_rad - points.front()).norm(); };
  int last = 0;
  // a hand that is not at the grasp does not go there first
  while (after_contact && last < kPoints - 1 && off_rad(last + 1) < off_rad(last)) ++last;
  for (int i = last + 1; i <= kPoints; ++i) points.push_back(planned.sample(s * i / kPoints).q_rad);
  planner::MotionLimits limits = planner::limits_of(c_.rig.model, c_.config.motion);
  limits.velocity_rad_s =
      limits.velocity_rad_s.cwiseMin(c_.config.setpoints.below(c_.config.guard_arm).velocity_rad_s);
  auto back = planner::make_trajectory_along(points, limits, s);
  if (!back)
    c_.attempts.failure = back.error().detail;
  else
    (void)c_.follow(*back);
}

bool RetreatPhase::may_touch() const {
  return leg_ == Leg::FromObject && contacts_ < kMaxContacts;
}

std::optional<TaskEvent> RetreatPhase::retreat() {
  c_.doing = leg_ == Leg::FromObject ? "straight back" : "home";
  if (c_.arm.blocked()) return TaskEvent{Event::Blocked, c_.arm.why_blocked()};
  if (c_.in_state_s() > c_.config.task.empty_hand.return_timeout_s)
    return TaskEvent{Event::TimeOut, "timeout"};
  object_.update();
  if (!c_.arm.done() || !c_.arm.at_rest()) return std::nullopt;
  if (leg_ == Leg::Home) return judge_at_home();
  leg_ = Leg::Home;
  if (!start_home()) return TaskEvent{Event::TimeOut, c_.attempts.failure};
  return std::nullopt;
}

bool RetreatPhase::start_home() {
  const planner::Trajectory& planned = c_.record.plan->home;
  if ((planned.goal() - home_rad_).norm() < 1e-3) return c_.follow(planned);
  const auto found = c_.motion_planner.plan_to(c_.arm.commanded(), home_rad_);
  if (found) return c_.follow(*found);
  c_.attempts.failure = found.error().detail;
  return false;
}

TaskEvent RetreatPhase::judge_at_home() {
  const Attempts& attempts = c_.attempts;
  if (!attempts.failed) {
    if (const std::string against = evidence_.against(); !against.empty())
      return {Event::BackInVain, against};
    return {Event::BackHome, ""};
  }
  const double moved_m = object_.displacement_m();
  const AttemptConfig& limits = c_.config.task.attempts;
  const int max_approaches = (attempts.touched ? limits.max_approaches : limits.max_grips) +
                             static_cast<int>(c_.record.test_lifts.size());
  if (!attempts.regrasp &&
      (attempts.approaches >= max_approaches || attempts.lifted || c_.readings.without_puck))
    return {Event::BackInVain, attempts.failure};
  if (moved_m > c_.config.task.attempts.object_moved_m)
    if (const std::string refused = take_scene_as_moved(); !refused.empty())
      return {Event::BackInVain,
              fmt::format("{}; the object moved by {:.0f} mm: {}", attempts.failure, 1e3 * moved_m, refused)};
  return {Event::TryAgain, attempts.failure};
}

std::string RetreatPhase::take_scene_as_moved() {
  if (object_.displacement_m() > c_.config.task.attempts.max_object_moved_m) return "that is another scene";
  const hal::Pose X = object_.motion()->X_WTnow_WTref;
  if (auto seen = c_.session.object_moved(X, c_.posture()); !seen) return seen.error().detail;
  if (!c_.session.analysis().scene.target) return "it is not seen there";
  scene_.use_scene();
  c_.test_lifts.move(X);
  grasps_.object_moved(X);
  object_.forget_motion();
  return "";
}

}  // namespace colift::control
