#pragma once

#include <optional>
#include <string>

#include "control/task/task_context.hpp"

namespace colift::control {

/// Yield: the arm was stopped by force that nobody expected. It stays soft, its load compensated, until the
/// force has been gone for a while; what comes then, a person decides. A hand that has raised nothing yet
/// opens: whoever is between it and the object is not to be held there.
class YieldPhase {
 public:
  explicit YieldPhase(TaskContext& context) : c_(context) {}

  void begin(Task from, const std::string& why);
  [[nodiscard]] std::optional<TaskEvent> yield();
  /// What the hand held was pushed out of it: it bears no load any more, the hand says so, or its fingers
  /// feel nothing. A hand that was closed on something may not know.
  [[nodiscard]] bool lost() const { return !lost_.empty(); }

 private:
  TaskContext& c_;
  void watch_grip();

  bool keeps_ = false;  ///< It held something, and was not told to open.
  std::string why_, lost_;
  hal::Timestamp pushed_at_{0}, felt_at_{0};
};

}  // namespace colift::control
