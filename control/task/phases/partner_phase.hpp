#pragma once

#include <optional>

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

 private:
  TaskContext& c_;
  PartnerMonitor& partner_;
  PartnerRequests& requests_;
  GraspSelector& grasps_;
};

}  // namespace colift::control
