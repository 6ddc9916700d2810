#include "control/task/supervision/stall_supervisor.hpp"

#include <fmt/format.h>

#include <utility>

namespace colift::control {

void StallSupervisor::read() {
  const SupervisionConfig& limits = c_.config.task.supervision;
  const ArmView& view = c_.arm.view();
  const hal::Duration gap = c_.now - std::exchange(read_at_, c_.now);
  if (view.stalls != stalls_) {
    stalls_ = view.stalls;
    c_.note_device("task", describe_stall(view));
    stalled_at_ = in_time_since_ = c_.now;
  }
  if (!stalled_at_) return;
  // an arm that was only coming to rest, or was asked for something else meanwhile, is not waited for
  if (!view.stalled || !is_moving(c_.state)) return stalled_at_.reset();
  if (view.stall_s > limits.stall_timeout_s)
    fault_ = fmt::format("for {:.2f} s (limit {:.2f} s)", view.stall_s, limits.stall_timeout_s);
  else if (stalls_ > static_cast<std::uint32_t>(limits.max_stalls))
    fault_ = fmt::format("{} times (limit {})", stalls_, limits.max_stalls);
  if (!fault_.empty()) return;
  if (gap > hal::duration_of(limits.beat_timeout_s)) in_time_since_ = c_.now;
  const bool in_time = c_.now - in_time_since_ >= hal::duration_of(limits.stall_recovery_s);
  const bool seen = c_.readings.camera_lost || c_.readings.frame_at > *stalled_at_;
  if (!in_time || !seen || !view.at_rest) return;
  c_.note_device("task", "runs in time again: the arm continues");
  stalled_at_.reset();
  recovered_ = true;
}

bool StallSupervisor::take_recovery() {
  return std::exchange(recovered_, false);
}

}  // namespace colift::control
