#include "control/task/phases/yield_phase.hpp"

#include "control/task/grip_quality.hpp"

namespace colift::control {
namespace {

constexpr double kFeels = 0.2, kSure_s = 0.3;  // of the torque that was asked; for so long

}  // namespace

void YieldPhase::begin(Task from, const std::string& why) {
  why_ = why;
  lost_.clear();
  pushed_at_ = felt_at_ = c_.now;
  c_.arm.yield();
  const bool stands = from == Task::Close || from == Task::Verify || from == Task::AwaitReady;
  keeps_ = !stands && c_.readings.hand.held;
  if (!stands) return;
  c_.arm.unload();
  if (const auto opening = c_.robot.hand->release(); !opening) c_.note_device("hand", opening.error().text());
}

std::optional<TaskEvent> YieldPhase::yield() {
  const ForceMonitorConfig& config = c_.config.monitor.force;
  watch_grip();
  c_.doing = lost() ? "the arm is soft, and the hand has lost what it held" : "the arm is soft: push it free";
  if (!c_.arm.view().force_quiet) pushed_at_ = c_.now;
  const bool free = hal::seconds(c_.now - pushed_at_) >= config.yield_s;
  if (free || c_.in_state_s() >= config.max_yield_s) return TaskEvent{Event::TimeOut, why_ + lost_};
  return std::nullopt;
}

// the gauges of fingers that wrap a bar do not feel it
void YieldPhase::watch_grip() {
  const hal::HandState& hand = c_.readings.hand;
  const double held = grip_quality(hand, c_.config.task.close_torque_nm, c_.config.task.grip).held_fraction;
  const bool wraps = c_.record.decision && c_.chosen().kind == planner::GraspKind::Wrap;
  if (!hand.held || wraps || !(held < kFeels)) felt_at_ = c_.now;
  if (c_.arm.view().load_lost)
    lost_ = "; the load is gone from the hand";
  else if (keeps_ && !hand.held)
    lost_ = "; the hand has lost its grip";
  else if (hal::seconds(c_.now - felt_at_) > kSure_s)
    lost_ = "; the fingers feel nothing between them any more";
  else
    lost_.clear();
}

}  // namespace colift::control
