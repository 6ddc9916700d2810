#pragma once

#include <optional>
#include <string>
#include <vector>

#include "control/task/task_context.hpp"

namespace colift::control {

/// One camera's frames: only those that are new, whole and not a repeated image. A camera that gives none for
/// a while is lost; one that is unplugged is opened again from time to time.
class CameraFeed {
 public:
  /// `name`: in messages (hal::camera_name()).
  CameraFeed(hal::DepthCamera& camera, std::string name) : camera_(camera), name_(std::move(name)) {}

  void start(hal::Timestamp now) { frame_at_ = now; }
  /// Once in each cycle: its new frame, if there is one.
  [[nodiscard]] std::optional<hal::DepthFrame> read(TaskContext& context);

  [[nodiscard]] const std::string& name() const { return name_; }
  [[nodiscard]] bool lost() const { return lost_; }
  [[nodiscard]] hal::Timestamp frame_at() const { return frame_at_; }  ///< Exposure of the newest good frame.

 private:
  [[nodiscard]] std::optional<hal::DepthFrame> accept(TaskContext& context, hal::DepthFrame frame);

  hal::DepthCamera& camera_;
  std::string name_;
  std::vector<float> last_depth_m_;
  hal::Timestamp frame_at_{0}, reopen_at_{0};
  int timely_ = 0;  ///< Good frames in a row that came in time.
  bool lost_ = false;
};

}  // namespace colift::control
