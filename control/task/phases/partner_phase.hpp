#pragma once

#include <optional>
#include <string>
#include <utility>

#include "control/task/grasp_selector.hpp"
#include "control/task/partner_monitor.hpp"
#include "control/task/partner_requests.hpp"
#include "control/task/task_context.hpp"

namespace colift::control {

/// AwaitPartner: waits until somebody grasps the object, or grasps it where he was asked to.
class PartnerPhase {
 public:
  PartnerPhase(TaskContext& context, PartnerMonitor& partner, PartnerRequests& requests,
               GraspSelector& grasps)
      : c_(context), partner_(partner), requests_(requests), grasps_(grasps) {}

  void begin(Task from);
  [[nodiscard]] std::optional<TaskEvent> await_partner();
  /// Which way he was asked to step aside since the last call (HiddenEdge::aside_W).
  [[nodiscard]] std::optional<hal::Vec3> take_aside() { return std::exchange(aside_W_, std::nullopt); }

 private:
  /// Who stands so that his body hides where his hand may be is asked to step aside, once.
  void ask_to_show_hand();
  /// The scene has been another one for a while, and nobody is there: a new one can be seen.
  [[nodiscard]] bool has_to_look_again();

  TaskContext& c_;
  PartnerMonitor& partner_;
  PartnerRequests& requests_;
  GraspSelector& grasps_;
  std::optional<hal::Timestamp> hidden_since_, changed_since_;
  int looked_again_ = 0;
  std::string asked_;  ///< What he was asked.
  std::optional<hal::Vec3> aside_W_;
};

}  // namespace colift::control
