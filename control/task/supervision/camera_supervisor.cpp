#include "control/task/supervision/camera_supervisor.hpp"

#include <algorithm>
#include <utility>

namespace colift::control {

CameraSupervisor::CameraSupervisor(TaskContext& context) : c_(context) {
  feeds_.emplace_back(*c_.robot.camera, hal::camera_name(0));
  for (const auto& camera : c_.robot.more_cameras)
    feeds_.emplace_back(*camera, hal::camera_name(feeds_.size()));
  pushed_.assign(feeds_.size(), 0);
}

void CameraSupervisor::start() {
  for (CameraFeed& feed : feeds_) feed.start(c_.now);
  c_.readings.frame_at = c_.now;
}

bool CameraSupervisor::usable(std::size_t camera) const {
  return !feeds_[camera].lost() && pushed_[camera] == 0;
}

void CameraSupervisor::read_others() {
  for (std::size_t n = 0; n < feeds_.size(); ++n) {
    if (n == c_.session.leading()) continue;
    auto frame = feeds_[n].read(c_);
    if (!frame) continue;
    const RobotPosture posture = c_.past.at(frame->exposed_at, c_.posture());
    c_.session.take_frame(n, std::move(*frame), posture);
  }
}

void CameraSupervisor::note_pushed() {
  const auto pushed = c_.session.take_pushed();
  if (!pushed) return;
  pushed_[pushed->camera] = 1;
  c_.note_device(feeds_[pushed->camera].name(), pushed->reason);
}

bool CameraSupervisor::hand_over() {
  for (std::size_t n = 0; n < feeds_.size(); ++n) {
    if (n == c_.session.leading() || !usable(n) || !c_.session.lead(n)) continue;
    c_.note_device("camera", feeds_[n].name() + " leads from here on");
    return true;
  }
  return false;
}

void CameraSupervisor::read() {
  DeviceReadings& r = c_.readings;
  const hal::Duration timeout = hal::duration_of(c_.config.task.supervision.camera_timeout_s);
  r.frame.reset();
  note_pushed();
  read_others();
  const std::size_t lead = c_.session.leading();
  auto frame = feeds_[lead].read(c_);
  if (!usable(lead) && hand_over()) {
    r.frame_at = feeds_[c_.session.leading()].frame_at();
    r.camera_lost = false;
    return;  // its next frame is the first one
  }
  r.camera_lost = !usable(lead);
  if (!frame || pushed_[lead] != 0) return;
  r.frame_at = frame->exposed_at;
  r.frame_latency = std::clamp<hal::Duration>(c_.now - r.frame_at, hal::Duration(0), timeout);
  r.frame = std::move(*frame);
}

}  // namespace colift::control
