#pragma once

#include <optional>

#include "control/task/partner_monitor.hpp"
#include "control/task/task_context.hpp"

namespace colift::control {

/// Approach and Halt: to the pre-grasp, then straight to the grasp, hand open, while the partner is watched;
/// at rest on the path while the camera is lost. With a hand that does not open nothing approaches.
class ApproachPhase {
 public:
  /// None: not under way, or the arm could not start. Announced: at rest, about to set out.
  enum class Leg { None, Announced, Transit, Straight };

  ApproachPhase(TaskContext& context, PartnerMonitor& partner) : c_(context), partner_(partner) {}

  void begin();
  [[nodiscard]] std::optional<TaskEvent> approach();

  void begin_halt() { c_.arm.hold(); }
  [[nodiscard]] std::optional<TaskEvent> halt() const;

  /// The arm's cycle was cut off and began anew: continues along the path.
  void resume_after_restart();
  /// The approach is given up; whether it had come to the straight leg, near the object.
  [[nodiscard]] bool abandon();

  /// Since begin(), the arm has moved towards the grasp.
  [[nodiscard]] bool set_out() const { return set_out_; }

  [[nodiscard]] Leg leg() const { return leg_; }

 private:
  /// Opens the hand and sets out, once that was announced.
  void set_out_when_announced();
  /// Why the hand counts as one that does not open; empty: it is open, or still at it.
  [[nodiscard]] std::string hand_stays_closed() const;

  TaskContext& c_;
  PartnerMonitor& partner_;
  Leg leg_ = Leg::None;
  bool set_out_ = false;
  std::string refusal_;          ///< Of the hand to open.
  hal::Timestamp opened_at_{0};  ///< When the hand was asked to open.
};

}  // namespace colift::control
