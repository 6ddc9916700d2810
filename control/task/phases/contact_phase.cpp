#include "control/task/phases/contact_phase.hpp"

namespace colift::control {

void ContactPhase::begin(const std::string& why) {
  why_ = why;
  began_at_ = pushed_at_ = c_.now;
  c_.arm.yield();
}

std::optional<TaskEvent> ContactPhase::contact(bool nobody_near) {
  const EmptyHandConfig& limits = c_.config.task.empty_hand;
  const double yield_s = c_.config.monitor.force.yield_s;
  c_.doing = "the arm is soft, until the force is gone";
  if (!nobody_near) return TaskEvent{Event::Blocked, "somebody is near: " + why_};
  if (!c_.arm.view().force_quiet) pushed_at_ = c_.now;
  if (hal::seconds(pushed_at_ - began_at_) > limits.max_touch_s)
    return TaskEvent{Event::Blocked, "the force stays: " + why_};
  if (c_.in_state_s() > yield_s + limits.max_touch_s + limits.approach_timeout_margin_s)
    return TaskEvent{Event::TimeOut, "the arm takes no commands"};
  const double quiet_s = hal::seconds(c_.now - pushed_at_);
  // announced while the arm is soft, not while it stands after that
  if (quiet_s < yield_s - c_.config.task.intent_lead_s || !c_.may_begin(Motion::Retreat)) return std::nullopt;
  if (quiet_s < yield_s) return std::nullopt;
  return TaskEvent{Event::ForceGone, why_};
}

}  // namespace colift::control
