#include "control/task/phases/scene_phase.hpp"

#include <fmt/format.h>

#include <memory>
#include <utility>

#include "control/session/picture_check.hpp"

namespace colift::control {

std::optional<TaskEvent> ScenePhase::observe() {
  PerceptionSession& session = c_.session;
  const TaskConfig& task = c_.config.task;
  if (c_.readings.frame) session.add_reference(std::move(*c_.readings.frame), c_.posture());
  const int have = session.reference_frames(), want = task.reference_frames;
  c_.doing = fmt::format("{} of {} frames of the scene", have, want);
  c_.done = static_cast<double>(have) / want;
  if (have < want) {
    if (c_.in_state_s() <= task.partner_timeout_s) return std::nullopt;
    return TaskEvent{Event::TimeOut,
                     last_error_.empty()
                         ? fmt::format("the camera showed nothing for {:.1f} s", c_.in_state_s())
                         : last_error_};
  }
  auto seen = session.analyse_scene(c_.posture());
  note_correction();
  if (!seen) {
    const hal::Error& error = seen.error();
    // somebody walked through the picture
    if (error.code == hal::ErrorCode::NotFound && try_again(error.detail)) return std::nullopt;
    return TaskEvent{error.where == kCameraOff ? Event::CameraOff : Event::NothingToCarry, error.detail};
  }
  note_views();
  const SceneAnalysis& analysis = session.analysis();
  if (!analysis.scene.target) {
    c_.record.analysis = analysis;
    return TaskEvent{Event::NothingToCarry, analysis.reason};
  }
  if (auto holes = image_fault(analysis.cloud, *analysis.scene.target, c_.config.image_check)) {
    // the sun may go behind a cloud
    if (try_again(*holes)) return std::nullopt;
    c_.record.analysis = analysis;
    return TaskEvent{Event::NothingToCarry, *std::move(holes)};
  }
  use_scene();
  return TaskEvent{Event::SceneKnown, c_.record.analysis->reason};
}

void ScenePhase::note_correction() {
  const auto& correction = c_.session.camera_correction();
  const auto& noted = c_.record.camera_correction;
  if (c_.session.scene_camera() != 0) return;  // pictures and recordings are the first camera's
  if (!correction || (noted && noted->verdict == correction->verdict)) return;
  c_.record.camera_correction = correction;
  // a camera that is used otherwise than it was calibrated is never silent
  if (correction->applied()) c_.note_device("camera", correction->reason);
}

void ScenePhase::note_views() {
  const auto& views = c_.session.views();
  for (std::size_t n = 0; n < views.size(); ++n) {
    const bool known = n < c_.record.views.size() && c_.record.views[n].used == views[n].used;
    if (n != c_.session.scene_camera() && !views[n].used && !known)
      c_.note_device(hal::camera_name(n), "is not used: " + views[n].reason);
  }
  c_.record.views = views;
  c_.record.unseen = c_.session.unseen();
}

bool ScenePhase::try_again(const std::string& error) {
  if (c_.in_state_s() >= c_.config.task.partner_timeout_s) return false;
  c_.session.forget_reference();
  c_.doing = last_error_ = error;
  return true;
}

void ScenePhase::use_scene() {
  c_.see_object(hal::Pose::Identity());
  c_.use_map();
  grasps_.set_scene();
}

}  // namespace colift::control
