#include "control/task/supervision/hand_supervisor.hpp"

#include <algorithm>
#include <array>
#include <string_view>
#include <utility>

namespace colift::control {
namespace {

// The puck that an error of the hand is of alone; its `where` says so ("hand.f2.state", "hand.spread").
std::optional<std::size_t> puck_named_in(const hal::Error& error) {
  constexpr std::array<std::string_view, 4> kNames{"hand.f1", "hand.f2", "hand.f3", "hand.spread"};
  for (std::size_t i = 0; i < kNames.size(); ++i)
    if (error.where.starts_with(kNames[i])) return i;
  return std::nullopt;
}

}  // namespace

void HandSupervisor::read() {
  if (auto state = c_.robot.hand->state()) {
    c_.readings.hand = *state;
    // as old as it was measured: a hand whose thread stands still repeats its last state
    answered_at_ = state->measured_at.count() > 0 ? std::min(state->measured_at, c_.now) : c_.now;
    if (lost_) c_.note_device("hand", "answers again");
    lost_ = false;
    if (auto warning = c_.readings.hand.warning.str(); warning != warning_) {
      warning_ = std::move(warning);
      if (!warning_.empty()) c_.note_device("hand", warning_);
    }
  } else {
    fault_ = state.error().text();
    silent_puck_ = puck_named_in(state.error());
    // one answer that cannot be is as good as none: a bus flips bits; an answer that stays so is no hand
    const hal::ErrorCode code = state.error().code;
    const bool transient = code == hal::ErrorCode::Timeout || code == hal::ErrorCode::BadReply;
    const bool gone =
        !transient || c_.now - answered_at_ > hal::duration_of(c_.config.task.supervision.hand_timeout_s);
    if (gone && !lost_) c_.note_device("hand", fault_);
    lost_ = lost_ || gone;
  }
}

void HandSupervisor::continue_without_puck() {
  c_.readings.without_puck = silent_puck_;
  lost_ = false;
}

}  // namespace colift::control
