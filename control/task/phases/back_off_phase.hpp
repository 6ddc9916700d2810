#pragma once

#include <optional>

#include "control/task/partner_monitor.hpp"
#include "control/task/task_context.hpp"

namespace colift::control {

/// BackOff: brakes and goes back along the path it came by, hand empty, because the grasp is off.
class BackOffPhase {
 public:
  enum class Leg { Braking, Backwards, Home };

  BackOffPhase(TaskContext& context, PartnerMonitor& partner) : c_(context), partner_(partner) {}

  /// `cause`: the event that made the grasp off; `near_object`: the arm was on the straight approach;
  /// `set_out`: it has moved at all.
  void begin(Event cause, bool near_object, bool set_out = true);
  [[nodiscard]] std::optional<TaskEvent> back_off();
  /// The arm's cycle was cut off and began anew: continues along the path.
  void resume_after_restart();

  [[nodiscard]] Leg leg() const { return leg_; }

 private:
  TaskContext& c_;
  PartnerMonitor& partner_;
  Leg leg_ = Leg::Braking;
  Event cause_ = Event::PartnerMoved;
  bool near_object_ = false, set_out_ = true;
};

}  // namespace colift::control
