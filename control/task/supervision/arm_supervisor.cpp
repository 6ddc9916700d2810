#include "control/task/supervision/arm_supervisor.hpp"

#include <fmt/format.h>

#include <utility>

namespace colift::control {
void ArmSupervisor::read(const std::string& slow_reason) {
  c_.arm.begin_cycle();
  c_.now = c_.robot.clock->now();
  const ArmView& view = c_.arm.view();
  c_.readings.arm = view.state;
  if (!thread_runs()) return;
  const bool answers = view.misses == 0;
  // commanded, and not any more before anybody looked here
  had_command_ = had_command_ || view.starts > 0;
  if (answers && !had_command_ && !view.state.may_command) return;
  if (!answers || !view.state.may_command || !view.running) return not_commanded();

  had_command_ = true;
  lost_ = false;
  // also when it was too short to be noticed here
  if (view.starts != starts_) restarted_ = restarted_ || starts_ != 0;
  starts_ = view.starts;
  if (interrupted_since_) {
    const hal::Duration stood = c_.now - *interrupted_since_;
    interrupted_since_.reset();
    c_.session.looked_away(stood);
    c_.note_device("arm", fmt::format("takes commands again after {:.2f} s", hal::seconds(stood)));
  }
  if (view.slow != slow_) {
    slow_ = view.slow;
    const std::string why = slow_reason.empty() ? c_.robot.arm->health().last_error : slow_reason;
    c_.note_device("arm", slow_ ? "continues at reduced speed: " + why : "goes at its full speed again");
  }
}

bool ArmSupervisor::thread_runs() {
  if (c_.options.drive != Drive::Thread) return true;
  const ArmView& view = c_.arm.view();
  const double silent_s = thread_.update(view.cycles + view.missed, c_.now);
  if (silent_s <= c_.config.task.supervision.beat_timeout_s) return true;
  if (!lost_) {
    fault_ = fmt::format("the arm's thread did not run for {:.2f} s", silent_s);
    c_.note_device("arm", fault_);
  }
  lost_ = true;
  return false;
}

void ArmSupervisor::not_commanded() {
  if (lost_) return;
  const ArmView& view = c_.arm.view();
  const SupervisionConfig& limits = c_.config.task.supervision;
  bool gone = view.link_lost;
  std::string why = view.fault.str();
  if (view.misses == 0) {
    using State = hal::DeviceHealth::State;
    const hal::DeviceHealth health = c_.robot.arm->health();
    // Streaming: it has healed since the view was made
    gone = health.state != State::Stalled && health.state != State::Streaming;
    why = "the arm's controller takes no commands any more: " + health.last_error;
  } else if (!gone &&
             view.misses <= (had_command_ ? limits.arm_max_misses : limits.arm_max_misses_at_start)) {
    return;
  }
  if (!had_command_) gone = true;
  if (!interrupted_since_) {
    interrupted_since_ = c_.now;
    c_.note_device("arm", gone ? why : why + "; waits until it does again");
  } else if (gone) {
    c_.note_device("arm", why);
  } else if (const double stood = hal::seconds(c_.now - *interrupted_since_);
             stood > c_.config.task.arm_timeout_s) {
    gone = true;
    why += fmt::format(" (for {:.1f} s)", stood);
    c_.note_device("arm", why);
  }
  fault_ = why;
  lost_ = gone;
}

bool ArmSupervisor::take_restart() {
  return std::exchange(restarted_, false);
}

}  // namespace colift::control
