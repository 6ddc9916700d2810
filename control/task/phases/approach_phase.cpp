#include "control/task/phases/approach_phase.hpp"

#include <fmt/format.h>

#include <utility>

#include "hal/types/units.hpp"

namespace colift::control {

using perception::PartnerEvent;

void ApproachPhase::begin() {
  ++c_.attempts.approaches;
  c_.arm.start_tare();
  refusal_.clear();
  leg_ = Leg::Announced;
  set_out_ = false;
  set_out_when_announced();
}

void ApproachPhase::set_out_when_announced() {
  if (leg_ != Leg::Announced || !c_.may_begin(Motion::Approach)) return;
  leg_ = Leg::None;
  opened_at_ = c_.now;
  if (const auto opened = c_.robot.hand->preshape(0.0); !opened) {
    refusal_ = opened.error().text();
    c_.note_device("hand", refusal_);
    return;
  }
  set_out_ = c_.follow(c_.record.plan->transit);
  if (set_out_) leg_ = Leg::Transit;
}

std::optional<TaskEvent> ApproachPhase::approach() {
  const planner::MotionPlan& plan = *c_.record.plan;
  set_out_when_announced();
  const auto event = partner_.update();
  if (event && event->kind != PartnerEvent::Kind::Grasped) {
    const bool moved = event->kind == PartnerEvent::Kind::Moved;
    return TaskEvent{moved ? Event::PartnerMoved : Event::PartnerLetGo, event->reason};
  }
  if (c_.arm.blocked()) return TaskEvent{Event::Blocked, c_.arm.why_blocked()};
  const EmptyHandConfig& limits = c_.config.task.empty_hand;
  if (leg_ == Leg::Announced) {
    c_.doing = "announces that the arm will move";
    if (c_.in_state_s() > c_.config.task.intent_lead_s + limits.approach_timeout_margin_s)
      return TaskEvent{Event::TimeOut, "the arm takes no commands"};
    return std::nullopt;
  }
  if (const std::string closed = hand_stays_closed(); !closed.empty())
    return TaskEvent{Event::HandUnfit, closed};
  if (leg_ == Leg::None) return TaskEvent{Event::TimeOut, c_.attempts.failure};
  const double transit_s = plan.transit.duration_s(), straight_s = plan.approach.duration_s();
  const double total_s = transit_s + straight_s;
  const double passed_s =
      leg_ == Leg::Transit ? c_.arm.progress() * transit_s : transit_s + c_.arm.progress() * straight_s;
  c_.done = total_s > 0.0 ? passed_s / total_s : 1.0;
  c_.doing = leg_ == Leg::Transit ? "moving to the pre-grasp" : "straight to the grasp";
  if (c_.in_state_s() > limits.approach_timeout_factor * total_s / c_.config.task.slow_fraction +
                            limits.approach_timeout_margin_s)
    return TaskEvent{Event::TimeOut, "timeout"};
  // announced while the last of the way is done, not while the arm stands on it
  const bool near =
      !c_.arm_waits && leg_ == Leg::Straight && total_s - passed_s <= c_.config.task.intent_lead_s;
  const bool may_close = near && c_.may_begin(Motion::Close);
  if (c_.readings.hand.moving || !c_.arm.done()) return std::nullopt;
  if (leg_ == Leg::Transit) {
    leg_ = Leg::Straight;
    c_.arm.end_tare();
    if (!c_.follow(plan.approach)) return TaskEvent{Event::TimeOut, c_.attempts.failure};
    return std::nullopt;
  }
  if (!may_close) return std::nullopt;
  return TaskEvent{Event::Arrived, ""};
}

std::string ApproachPhase::hand_stays_closed() const {
  if (!refusal_.empty()) return "the hand refuses to open: " + refusal_;
  const GripConfig& limits = c_.config.task.grip;
  const double since_s = hal::seconds(c_.now - opened_at_);
  if (since_s < limits.command_shows_s) return "";
  const hal::HandState& hand = c_.readings.hand;
  if (hand.moving)
    return since_s < limits.hand_timeout_s
               ? ""
               : fmt::format("the hand is not open after {:.0f} s", limits.hand_timeout_s);
  for (std::size_t f = 0; f < hand.finger_rad.size(); ++f)
    if (hand.finger_rad[f] > limits.open_tolerance_rad && f != c_.readings.without_puck)
      return fmt::format("the hand did not open: finger {} is at {:.0f} deg (limit {:.0f} deg)", f + 1,
                         hal::rad_to_deg(hand.finger_rad[f]), hal::rad_to_deg(limits.open_tolerance_rad));
  return "";
}

std::optional<TaskEvent> ApproachPhase::halt() const {
  if (!c_.readings.camera_lost) return TaskEvent{Event::CameraBack, ""};
  if (c_.in_state_s() > c_.config.task.partner_timeout_s) return TaskEvent{Event::TimeOut, ""};
  return std::nullopt;
}

void ApproachPhase::resume_after_restart() {
  if (leg_ == Leg::Transit || leg_ == Leg::Straight) c_.arm.resume();
}

bool ApproachPhase::abandon() {
  return std::exchange(leg_, Leg::None) == Leg::Straight;
}

}  // namespace colift::control
