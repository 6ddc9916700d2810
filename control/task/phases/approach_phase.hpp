#pragma once

#include <optional>

#include "control/task/partner_monitor.hpp"
#include "control/task/task_context.hpp"

namespace colift::control {

/// Approach and Halt: to the pre-grasp, then straight to the grasp, hand open, while the partner is watched;
/// at rest on the path while the camera is lost.
class ApproachPhase {
 public:
  enum class Leg { None, Transit, Straight };  ///< None: not under way, or the arm could not start.

  ApproachPhase(TaskContext& context, PartnerMonitor& partner) : c_(context), partner_(partner) {}

  void begin();
  [[nodiscard]] std::optional<TaskEvent> approach();

  void begin_halt() { c_.arm.hold(); }
  [[nodiscard]] std::optional<TaskEvent> halt() const;

  /// The arm's cycle was cut off and began anew: continues along the path.
  void resume_after_restart();
  /// The approach is given up; whether it had come to the straight leg, near the object.
  [[nodiscard]] bool abandon();

  [[nodiscard]] Leg leg() const { return leg_; }

 private:
  TaskContext& c_;
  PartnerMonitor& partner_;
  Leg leg_ = Leg::None;
};

}  // namespace colift::control
