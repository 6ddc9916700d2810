#pragma once

#include <optional>
#include <string>

#include "control/task/task_context.hpp"

namespace colift::control {

/// Contact: at the end of its approach the open hand met something at the object that the camera does not
/// see. The arm is soft; when the force is gone it may go back and grasp elsewhere. A force that stays, or
/// somebody near, is no object's: then the arm yields, and a person decides.
class ContactPhase {
 public:
  explicit ContactPhase(TaskContext& context) : c_(context) {}

  void begin(const std::string& why);
  /// `nobody_near`: everybody is seen to be farther away than EmptyHandConfig::touch_clear_m.
  [[nodiscard]] std::optional<TaskEvent> contact(bool nobody_near);

 private:
  TaskContext& c_;
  std::string why_;
  hal::Timestamp began_at_{0}, pushed_at_{0};
};

}  // namespace colift::control
