#include "control/task/phases/back_off_phase.hpp"

namespace colift::control {
void BackOffPhase::begin(Event cause, bool near_object, bool set_out) {
  c_.arm.hold();
  cause_ = cause;
  near_object_ = near_object;
  set_out_ = set_out;
  leg_ = Leg::Braking;
}

std::optional<TaskEvent> BackOffPhase::back_off() {
  // the partner may grasp again meanwhile; that is seen once the arm is back
  (void)partner_.update();
  if (c_.in_state_s() > c_.config.task.empty_hand.return_timeout_s)
    return TaskEvent{Event::TimeOut, "timeout"};
  const int max_approaches =
      c_.config.task.attempts.max_approaches + static_cast<int>(c_.record.test_lifts.size());
  const bool in_vain = c_.attempts.approaches >= max_approaches;
  const bool follows_partner = cause_ == Event::PartnerMoved && !in_vain;
  const auto back = [&](const char* where) {
    return TaskEvent{in_vain ? Event::BackInVain : Event::BackHome, where};
  };
  if (leg_ == Leg::Braking) {
    if (!c_.arm.at_rest()) return std::nullopt;
    if (!set_out_) return back("the arm had not moved");
    if (follows_partner && !near_object_) return back("at rest, clear of the object");
    if (!c_.may_begin(Motion::Return)) return std::nullopt;
    c_.arm.back(c_.config.task.empty_hand.back_off_scale);
    leg_ = Leg::Backwards;
    return std::nullopt;
  }
  if (c_.arm.blocked()) return TaskEvent{Event::Blocked, c_.arm.why_blocked()};
  if (!c_.arm.done() || !c_.arm.at_rest()) return std::nullopt;
  if (leg_ == Leg::Backwards && near_object_) {
    // clear of the object: who only moved his hand is followed from here
    if (follows_partner) return back("clear of the object");
    leg_ = Leg::Home;
    if (!c_.follow(c_.record.plan->home)) return TaskEvent{Event::TimeOut, c_.attempts.failure};
    return std::nullopt;
  }
  return back("back where it started");
}

void BackOffPhase::resume_after_restart() {
  if (leg_ == Leg::Home)
    c_.arm.resume();
  else if (leg_ == Leg::Backwards)
    c_.arm.back(c_.config.task.empty_hand.back_off_scale);
}

}  // namespace colift::control
