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
  /// The scene with the partner, and what obstructed the last path at least so far away.
  void enter_scene(double obstacle_clearance_m);
  [[nodiscard]] TaskEvent take(planner::MotionPlan plan, hal::Timestamp began);

  TaskContext& c_;
  const PartnerMonitor& partner_;
  PartnerRequests& requests_;
  GraspSelector& grasps_;
};

}  // namespace colift::control
