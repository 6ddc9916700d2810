// Whether the arm is there, and what is done when it stood for a while: packets lost, quality gone. Its
// driver comes to rest by itself, and goes on by itself from the measured pose when the link has healed; what
// needs a person (command mode left, drives off, a fault) is told at once.

#include <fmt/format.h>

#include "control/task/job.hpp"

namespace colift::control {
namespace {

constexpr int kFewMisses = 5;       // cycles in a row that every driver spans
constexpr int kMissesAtStart = 20;  // before the arm was ever commanded; Franka gives up after 20 too

}  // namespace

void Job::read_arm() {
  loop_.begin_cycle();
  now_ = robot_.clock->now();
  const ArmView& view = loop_.view();
  arm_ = view.state;
  const bool answers = view.misses == 0;
  if (answers && !had_command_ && !arm_.may_command) return;
  if (!answers || !arm_.may_command || !view.running) return stand();

  had_command_ = true;
  arm_silent_ = false;
  // also when it was too short to be noticed here
  if (view.starts != starts_) cut_off_ = cut_off_ || starts_ != 0;
  starts_ = view.starts;
  if (stands_since_) {
    const hal::Duration stood = now_ - *stands_since_;
    stands_since_.reset();
    watch_.looked_away(stood);
    lose("arm", fmt::format("takes commands again after {:.2f} s", hal::seconds(stood)));
  }
  if (view.slow != slow_) {
    slow_ = view.slow;
    const std::string why = slow_because_.empty() ? robot_.arm->health().last_error : slow_because_;
    lose("arm", slow_ ? "goes on slowly: " + why : "goes at its full speed again");
  }
}

void Job::stand() {
  if (arm_silent_) return;
  const ArmView& view = loop_.view();
  bool gone = view.link_lost;
  std::string why = view.trouble.str();
  if (view.misses == 0) {
    using State = hal::DeviceHealth::State;
    const hal::DeviceHealth health = robot_.arm->health();
    // Streaming: it has healed since the view was made
    gone = health.state != State::Stalled && health.state != State::Streaming;
    why = "the arm's controller takes no commands any more: " + health.last_error;
  } else if (!gone && view.misses <= (had_command_ ? kFewMisses : kMissesAtStart)) {
    return;
  }
  if (!had_command_) gone = true;
  if (!stands_since_) {
    stands_since_ = now_;
    lose("arm", gone ? why : why + "; waits until it does again");
  } else if (gone) {
    lose("arm", why);
  } else if (const double stood = hal::seconds(now_ - *stands_since_); stood > config_.task.arm_patience_s) {
    gone = true;
    why += fmt::format(" (for {:.1f} s)", stood);
    lose("arm", why);
  }
  arm_trouble_ = why;
  arm_silent_ = gone;
}

bool Job::waits_for_arm() const {
  return stands_since_ && state_ != Task::Observe && state_ != Task::AwaitPartner;
}

void Job::take_up() {
  cut_off_ = false;
  lose("arm", "goes on from where it stands");
  // a hand at work goes on with it, and a lift by itself: from its height
  if ((state_ == Task::Approach && leg_ >= 0) || state_ == Task::Retreat ||
      (state_ == Task::BackOff && leg_ == 4))
    loop_.resume();
  else if (state_ == Task::BackOff && leg_ == 3)
    loop_.back(kBackSpeed);
}

}  // namespace colift::control
