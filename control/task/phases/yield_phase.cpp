#include "control/task/phases/yield_phase.hpp"

namespace colift::control {

void YieldPhase::begin(Task from, const std::string& why) {
  why_ = why;
  pushed_at_ = c_.now;
  c_.arm.yield();
  const bool stands = from == Task::Close || from == Task::Verify || from == Task::AwaitReady;
  if (!stands) return;
  c_.arm.unload();
  if (const auto opening = c_.robot.hand->release(); !opening) c_.note_device("hand", opening.error().text());
}

std::optional<TaskEvent> YieldPhase::yield() {
  const ForceMonitorConfig& config = c_.config.monitor.force;
  const bool lost = c_.arm.view().load_lost;
  c_.doing = lost ? "the arm is soft, and the hand has lost its load" : "the arm is soft: push it free";
  if (!c_.arm.view().force_quiet) pushed_at_ = c_.now;
  const bool free = hal::seconds(c_.now - pushed_at_) >= config.yield_s;
  if (free || c_.in_state_s() >= config.max_yield_s)
    return TaskEvent{Event::TimeOut, lost ? why_ + "; the load is gone from the hand" : why_};
  return std::nullopt;
}

}  // namespace colift::control
