#pragma once

#include <optional>
#include <string>

#include "control/task/let_go_monitor.hpp"
#include "control/task/object_monitor.hpp"
#include "control/task/task_context.hpp"

namespace colift::control {

/// Pause: a raised object is held on the spot, because the partner let go or it met something on its way
/// down. He is asked to take it up again; nothing lowers it by itself, a person may be under it.
class PausePhase {
 public:
  PausePhase(TaskContext& context, ObjectMonitor& object, LetGoMonitor& partner)
      : c_(context), object_(object), partner_(partner) {}

  void begin(Task from, Event event, std::string why);
  [[nodiscard]] std::optional<TaskEvent> pause();
  /// A person confirmed lowering: the robot sets the object down, with the partner or without him.
  void lowering_confirmed();
  /// Where he is asked to grasp (W); unset when something else is asked of him.
  [[nodiscard]] std::optional<hal::Vec3> asked_place() const;

 private:
  [[nodiscard]] bool goes_on() const;
  /// It was lowered, and both of its ends are seen where they stood, up to millimetres: nothing falls,
  /// whoever holds it.
  [[nodiscard]] bool is_nearly_down() const;
  [[nodiscard]] bool holds_again() const;
  /// What continues now; after CarryConfig::max_regrasps no lift any more.
  [[nodiscard]] TaskEvent go_on();
  /// Next to nothing hangs in the hand, and both ends of the object are seen where they stood.
  [[nodiscard]] bool stands() const;
  /// It stands, and nobody took it up: the robot sets its end down and releases it.
  [[nodiscard]] TaskEvent put_down();
  [[nodiscard]] const char* request() const;

  TaskContext& c_;
  ObjectMonitor& object_;
  LetGoMonitor& partner_;
  Task from_ = Task::Lift;
  bool obstructed_ = false, pulled_ = false;
  int pauses_ = 0;  ///< Of this job, but those in which something was under the object.
  double load_at_start_n_ = 0.0;
  std::string why_;                 ///< It was paused.
  hal::Timestamp not_since_{0};     ///< When it was last not to go on ...
  hal::Timestamp hangs_at_{0};      ///< ... and not to stand.
  bool began_nearly_down_ = false;  ///< Both ends were within some millimetres of where they stood.
};

}  // namespace colift::control
