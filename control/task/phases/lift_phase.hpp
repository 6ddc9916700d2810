#pragma once

#include <cmath>
#include <optional>

#include "control/task/object_monitor.hpp"
#include "control/task/task_context.hpp"

namespace colift::control {

/// Lift, Hold and Lower: the object is in the air.
class LiftPhase {
 public:
  LiftPhase(TaskContext& context, ObjectMonitor& object) : c_(context), object_(object) {}

  void begin_lift(Task from);
  [[nodiscard]] std::optional<TaskEvent> lift();
  void begin_hold();
  [[nodiscard]] std::optional<TaskEvent> hold();
  /// Writes the summary of the hold into the record, too.
  void begin_lower();
  [[nodiscard]] std::optional<TaskEvent> lower();

 private:
  /// The commanded height has been reached for a moment.
  [[nodiscard]] bool settled();
  [[nodiscard]] std::optional<TaskEvent> partner_gone_or_lowers();
  void summarise_hold();

  TaskContext& c_;
  ObjectMonitor& object_;
  double lift_s_ = 0.0;                             ///< That this lift takes.
  hal::Timestamp moved_at_{0}, unsupported_at_{0};  ///< The palm; the object without the ground: last time.
  double mean_load_n_ = NAN;                        ///< Slow mean while held.
};

}  // namespace colift::control
