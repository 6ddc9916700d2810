#include "hal/drivers/capture_link/capture_monitor.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace colift::hal::capture {
namespace {

constexpr double kGrowth = 1.5;
constexpr std::uint64_t kSteady =
    60;  // frames: a process that gave so many begins with the short pause again

Duration of_seconds(double s) {
  return std::chrono::duration_cast<Duration>(std::chrono::duration<double>(s));
}

}  // namespace

void CaptureMonitor::want() {
  if (phase_ == Phase::Running || phase_ == Phase::Dying) return;
  phase_ = Phase::Pausing;
  until_ = Timestamp::min();
}

void CaptureMonitor::rest() {
  phase_ = Phase::Resting;
}

std::string CaptureMonitor::overdue(Timestamp now) const {
  if (frames_ == 0) {
    const double opens_s = seconds(now - since_);
    if (opens_s > times_.open_s) return fmt::format("no first frame within {:.1f} s", times_.open_s);
    return "";
  }
  if (const double silent_s = seconds(now - beat_at_); silent_s > times_.heartbeat_s)
    return fmt::format("no sign of life for {:.1f} s", silent_s);
  if (const double dark_s = seconds(now - frame_at_); dark_s > times_.frames_s)
    return fmt::format("alive, but no frame for {:.1f} s", dark_s);
  return "";
}

void CaptureMonitor::pause(const Sight& sight, Timestamp now) {
  if (frames_ >= kSteady) pause_s_ = 0.0;
  pause_s_ = pause_s_ == 0.0 ? times_.first_pause_s : std::min(kGrowth * pause_s_, times_.max_pause_s);
  if (sight.no_device) pause_s_ = times_.max_pause_s;
  phase_ = Phase::Pausing;
  until_ = now + of_seconds(pause_s_);
}

CaptureMonitor::Do CaptureMonitor::look(const Sight& sight, Timestamp now) {
  switch (phase_) {
    case Phase::Resting:
      return Do::Nothing;
    case Phase::Pausing:
      if (now < until_) return Do::Nothing;
      phase_ = Phase::Running;
      since_ = beat_at_ = frame_at_ = now;
      heartbeat_ = frames_ = 0;
      ++starts_;
      return Do::Start;
    case Phase::Running:
      if (!sight.exists) {
        why_ = sight.ended;
        pause(sight, now);
        return Do::Nothing;
      }
      if (sight.heartbeat != heartbeat_) heartbeat_ = sight.heartbeat, beat_at_ = now;
      if (sight.frames != frames_) frames_ = sight.frames, frame_at_ = now;
      if (const std::string late = overdue(now); !late.empty()) {
        why_ = late;
        phase_ = Phase::Dying;
        since_ = now;
        ++kills_;
        return Do::Kill;
      }
      return Do::Nothing;
    case Phase::Dying:
      if (!sight.exists) {
        pause(sight, now);
        return Do::Nothing;
      }
      if (seconds(now - since_) < times_.kill_s) return Do::Nothing;
      pause(sight, now);
      return Do::Abandon;
  }
  return Do::Nothing;
}

}  // namespace colift::hal::capture
