#pragma once

#include <cstddef>
#include <vector>

#include "control/task/supervision/camera_feed.hpp"
#include "control/task/task_context.hpp"

namespace colift::control {

/// Reads all cameras. The frames of one, which leads, go to the phases; those of the others to the perception
/// session, which joins them. When the leading one is lost or was pushed, another that knows the scene takes
/// over; the job has lost its camera when there is none.
class CameraSupervisor {
 public:
  explicit CameraSupervisor(TaskContext& context);

  void start();
  void read();

 private:
  [[nodiscard]] bool usable(std::size_t camera) const;
  void read_others();
  void note_pushed();
  /// Lets another camera lead; false: there is none.
  [[nodiscard]] bool hand_over();

  TaskContext& c_;
  std::vector<CameraFeed> feeds_;
  std::vector<char> pushed_;  ///< By camera: it does not count any more.
};

}  // namespace colift::control
