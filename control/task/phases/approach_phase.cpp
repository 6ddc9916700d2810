#include "control/task/phases/approach_phase.hpp"

#include <utility>

namespace colift::control {

using perception::PartnerEvent;

void ApproachPhase::begin() {
  ++c_.attempts.approaches;
  c_.arm.start_tare();
  if (const auto opened = c_.robot.hand->preshape(0.0); !opened)
    c_.note_device("hand", opened.error().text());
  leg_ = c_.follow(c_.record.plan->transit) ? Leg::Transit : Leg::None;
}

std::optional<TaskEvent> ApproachPhase::approach() {
  const planner::MotionPlan& plan = *c_.record.plan;
  const auto event = partner_.update();
  if (event && event->kind != PartnerEvent::Kind::Grasped) {
    const bool moved = event->kind == PartnerEvent::Kind::Moved;
    return TaskEvent{moved ? Event::PartnerMoved : Event::PartnerLetGo, event->reason};
  }
  if (c_.arm.blocked()) return TaskEvent{Event::Blocked, c_.arm.why_blocked()};
  if (leg_ == Leg::None) return TaskEvent{Event::Blocked, c_.attempts.failure};
  const double transit_s = plan.transit.duration_s(), straight_s = plan.approach.duration_s();
  const double total_s = transit_s + straight_s;
  const double passed_s =
      leg_ == Leg::Transit ? c_.arm.progress() * transit_s : transit_s + c_.arm.progress() * straight_s;
  c_.done = total_s > 0.0 ? passed_s / total_s : 1.0;
  c_.doing = leg_ == Leg::Transit ? "moving to the pre-grasp" : "straight to the grasp";
  const EmptyHandConfig& limits = c_.config.task.empty_hand;
  if (c_.in_state_s() > limits.approach_timeout_factor * total_s / c_.config.task.slow_fraction +
                            limits.approach_timeout_margin_s)
    return TaskEvent{Event::TimeOut, "timeout: motion to the grasp"};
  if (c_.readings.hand.moving || !c_.arm.done()) return std::nullopt;
  if (leg_ == Leg::Transit) {
    leg_ = Leg::Straight;
    c_.arm.end_tare();
    if (!c_.follow(plan.approach)) return TaskEvent{Event::Blocked, c_.attempts.failure};
    return std::nullopt;
  }
  return TaskEvent{Event::Arrived, ""};
}

std::optional<TaskEvent> ApproachPhase::halt() const {
  if (!c_.readings.camera_lost) return TaskEvent{Event::CameraBack, ""};
  if (c_.in_state_s() > c_.config.task.partner_timeout_s) return TaskEvent{Event::TimeOut, ""};
  return std::nullopt;
}

void ApproachPhase::resume_after_restart() {
  if (leg_ != Leg::None) c_.arm.resume();
}

bool ApproachPhase::abandon() {
  return std::exchange(leg_, Leg::None) == Leg::Straight;
}

}  // namespace colift::control
