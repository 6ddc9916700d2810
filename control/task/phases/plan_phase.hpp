#pragma once

#include <optional>

#include "control/task/grasp_selector.hpp"
#include "control/task/partner_monitor.hpp"
#include "control/task/partner_requests.hpp"
#include "control/task/task_context.hpp"

namespace colift::control {

/// Decide and Plan: which grasp, and a collision-free path to it. Nothing moves.
class PlanPhase {
 public:
  PlanPhase(TaskContext& context, const PartnerMonitor& partner, PartnerRequests& requests,
            GraspSelector& grasps)
      : c_(context), partner_(partner), requests_(requests), grasps_(grasps) {}

  void begin_decision() { grasps_.begin_decision(); }
  [[nodiscard]] TaskEvent decide();
  [[nodiscard]] TaskEvent plan();

 private:
  [[nodiscard]] TaskEvent find_path();

  TaskContext& c_;
  const PartnerMonitor& partner_;
  PartnerRequests& requests_;
  GraspSelector& grasps_;
};

}  // namespace colift::control
