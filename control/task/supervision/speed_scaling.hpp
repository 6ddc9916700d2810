#pragma once

#include <string>

#include "control/task/task_context.hpp"

namespace colift::control {

/// How fast the arm may go with what is known at this moment: slowly where the hand warns, the object turns
/// in a test lift, the camera is lost or its pictures are old.
class SpeedScaling {
 public:
  explicit SpeedScaling(TaskContext& context) : c_(context) {}

  void start() { updated_at_ = c_.now; }
  /// Once in each cycle, when the devices have been read: asks the arm for less or for full speed.
  void update(const std::string& hand_warning);

  /// Why the arm was asked to go slowly; empty: it was not.
  [[nodiscard]] const std::string& reason() const { return reason_; }
  /// Mean age of the newest picture over the last moments (s).
  [[nodiscard]] double image_age_s() const { return image_age_s_; }

 private:
  void update_image_age();

  TaskContext& c_;
  std::string reason_;
  hal::Timestamp updated_at_{0};
  double image_age_s_ = 0.0;  ///< Of the newest picture, in the mean over the last moments.
  bool images_old_ = false;
};

}  // namespace colift::control
