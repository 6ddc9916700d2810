#include "control/task/supervision/camera_supervisor.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <utility>

namespace colift::control {
namespace {

using namespace std::chrono_literals;

bool right_size(const hal::DepthFrame& f) {
  return f.depth_m.size() ==
         static_cast<std::size_t>(f.intrinsics.width) * static_cast<std::size_t>(f.intrinsics.height);
}

// bit by bit: pixels without depth are NaN
bool same_pixels(const std::vector<float>& a, const std::vector<float>& b) {
  return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(float)) == 0;
}

}  // namespace

void CameraSupervisor::read() {
  DeviceReadings& r = c_.readings;
  const hal::Duration timeout = hal::duration_of(c_.config.task.supervision.camera_timeout_s);
  const hal::Duration reopen = hal::duration_of(c_.config.task.supervision.camera_reopen_s);
  r.frame.reset();
  auto frame = c_.robot.camera->next_frame(0ms);
  // a picture that shows the moving arm where it was is an old one, whatever its stamp says
  const bool frozen = frame && is_moving(c_.state) && same_pixels(frame->depth_m, last_depth_m_);
  const bool good = frame && right_size(*frame) && frame->exposed_at > r.frame_at && !frozen;
  if (good) {
    last_depth_m_ = frame->depth_m;
    const double age_s = hal::seconds(c_.now - frame->exposed_at);
    timely_ = age_s < c_.config.task.supervision.slow_image_age_s ? timely_ + 1 : 0;
    // one that comes and goes is not back; before anything moves it may be
    const bool steady =
        timely_ >= c_.config.monitor.good_frames || !(is_moving(c_.state) || c_.state == Task::Halt);
    if (r.camera_lost && steady) {
      c_.note_device("camera", "is back");
      r.camera_lost = false;
    }
    r.frame_at = frame->exposed_at;
    r.frame_latency = std::clamp<hal::Duration>(c_.now - r.frame_at, hal::Duration(0), timeout);
    r.frame = std::move(*frame);
    return;
  }
  if (frame || c_.now - r.frame_at > timeout) timely_ = 0;
  const bool unplugged = !frame && frame.error().code == hal::ErrorCode::LinkLost;
  if (!r.camera_lost && (unplugged || c_.now - r.frame_at > timeout)) {
    r.camera_lost = true;
    reopen_at_ = c_.now + reopen;
    const bool has_reason = !frame && frame.error().code != hal::ErrorCode::Timeout;  // unplugged, moved
    c_.note_device("camera", has_reason
                                 ? frame.error().text()
                                 : fmt::format("no picture for {:.1f} s", hal::seconds(c_.now - r.frame_at)));
  }
  if (r.camera_lost && unplugged && c_.now >= reopen_at_) {
    reopen_at_ = c_.now + reopen;
    if (c_.robot.camera->configure()) (void)c_.robot.camera->activate();
  }
}

}  // namespace colift::control
