#include "control/task/phases/yield_phase.hpp"

namespace colift::control {

void YieldPhase::begin(const std::string& why) {
  why_ = why;
  pushed_at_ = c_.now;
  c_.arm.yield();
}

std::optional<TaskEvent> YieldPhase::yield() {
  const ForceMonitorConfig& config = c_.config.monitor.force;
  c_.doing = "the arm is soft: push it free";
  if (!c_.arm.view().force_quiet) pushed_at_ = c_.now;
  const bool free = hal::seconds(c_.now - pushed_at_) >= config.yield_s;
  if (free || c_.in_state_s() >= config.max_yield_s) return TaskEvent{Event::TimeOut, why_};
  return std::nullopt;
}

}  // namespace colift::control
