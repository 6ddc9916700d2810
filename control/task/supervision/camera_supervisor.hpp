#pragma once

#include <vector>

#include "control/task/task_context.hpp"

namespace colift::control {

/// Takes frames from the camera and passes on only those that are new, whole and not a repeated image.
/// A camera that gives none for a while is lost; one that is unplugged is opened again from time to time.
class CameraSupervisor {
 public:
  explicit CameraSupervisor(TaskContext& context) : c_(context) {}

  void start() { c_.readings.frame_at = c_.now; }
  void read();

 private:
  TaskContext& c_;
  std::vector<float> last_depth_m_;
  int timely_ = 0;  ///< Good frames in a row that came in time.
  hal::Timestamp reopen_at_{0};
};

}  // namespace colift::control
