#pragma once

#include <optional>

#include "control/task/let_go_monitor.hpp"
#include "control/task/object_monitor.hpp"
#include "control/task/partner_monitor.hpp"
#include "control/task/task_context.hpp"

namespace colift::control {

/// Close, Verify and AwaitReady: the hand closes, the grip is checked, the partner holds still. The object
/// stands on the ground all the time.
class GripPhase {
 public:
  GripPhase(TaskContext& context, PartnerMonitor& partner, ObjectMonitor& object, LetGoMonitor& let_go)
      : c_(context), partner_(partner), object_(object), let_go_(let_go) {}

  void begin_close();
  [[nodiscard]] std::optional<TaskEvent> close();
  void begin_verify();
  [[nodiscard]] std::optional<TaskEvent> verify();
  void begin_await_ready() { object_.start_lift(); }
  /// Decides who leads the lift, too: TaskContext::role.
  [[nodiscard]] std::optional<TaskEvent> await_ready();

 private:
  /// By what is seen at his contact; by the tracker only while his hand is not seen there.
  [[nodiscard]] std::optional<TaskEvent> let_go();
  /// He holds it by the tracker, or his hand is seen at his contact.
  [[nodiscard]] bool partner_holds() const;
  /// What tells that the fingers do not hold the object alone; nothing: they do.
  [[nodiscard]] std::optional<std::string> something_between(const hal::HandState& hand) const;
  /// What speaks against lifting with this grip, by the load that is expected; nothing: it bears it.
  [[nodiscard]] std::optional<std::string> too_weak(const GripQuality& quality) const;
  /// Lets go of what the closing fingers have strained.
  void ease();

  TaskContext& c_;
  PartnerMonitor& partner_;
  ObjectMonitor& object_;
  LetGoMonitor& let_go_;
  std::optional<TaskEvent> doubt_;  ///< The tracker says that he let go, while his hand is seen.
  hal::Timestamp eased_at_{0};
  hal::Vec3 closed_W_ = hal::Vec3::Zero();  ///< Where the palm stood when the hand had closed.
};

}  // namespace colift::control
