#include "control/task/supervision/camera_feed.hpp"

#include <fmt/format.h>

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

std::optional<hal::DepthFrame> CameraFeed::read(TaskContext& c) {
  const SupervisionConfig& limits = c.config.task.supervision;
  const hal::Duration timeout = hal::duration_of(limits.camera_timeout_s);
  const hal::Duration reopen = hal::duration_of(limits.camera_reopen_s);
  auto frame = camera_.next_frame(0ms);
  // a picture that shows the moving arm where it was is an old one, whatever its stamp says
  const bool frozen = frame && is_moving(c.state) && same_pixels(frame->depth_m, last_depth_m_);
  if (frame && right_size(*frame) && frame->exposed_at > frame_at_ && !frozen)
    return accept(c, std::move(*frame));
  if (frame || c.now - frame_at_ > timeout) timely_ = 0;
  const bool unplugged = !frame && frame.error().code == hal::ErrorCode::LinkLost;
  if (!lost_ && (unplugged || c.now - frame_at_ > timeout)) {
    lost_ = true;
    reopen_at_ = c.now + reopen;
    const bool has_reason = !frame && frame.error().code != hal::ErrorCode::Timeout;  // unplugged, moved
    c.note_device(name_, has_reason
                             ? frame.error().text()
                             : fmt::format("no picture for {:.1f} s", hal::seconds(c.now - frame_at_)));
  }
  if (lost_ && unplugged && c.now >= reopen_at_) {
    reopen_at_ = c.now + reopen;
    if (camera_.configure()) (void)camera_.activate();
  }
  return std::nullopt;
}

std::optional<hal::DepthFrame> CameraFeed::accept(TaskContext& c, hal::DepthFrame frame) {
  last_depth_m_ = frame.depth_m;
  const double age_s = hal::seconds(c.now - frame.exposed_at);
  timely_ = age_s < c.config.task.supervision.slow_image_age_s ? timely_ + 1 : 0;
  // one that comes and goes is not back; before anything moves it may be
  const bool steady =
      timely_ >= c.config.monitor.good_frames || !(is_moving(c.state) || c.state == Task::Halt);
  if (lost_ && steady) {
    c.note_device(name_, "is back");
    lost_ = false;
  }
  frame_at_ = frame.exposed_at;
  return frame;
}

}  // namespace colift::control
