#include "control/task/phases/plan_phase.hpp"

#include <fmt/format.h>

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "control/session/map_check.hpp"

namespace colift::control {
namespace {

constexpr double kNearer_m = 0.05;  // from one try to pass an obstacle to the next

}  // namespace

TaskEvent PlanPhase::decide() {
  if (auto picture = c_.picture()) c_.record.frame_partner = std::move(picture);
  const hal::Timestamp start = c_.stopwatch.now();
  const bool chosen = grasps_.choose();
  RunTiming& timing = c_.record.timing;
  timing.decision_compute_ms = partner_.compute_ms() + 1e3 * hal::seconds(c_.stopwatch.now() - start);
  timing.grasp_to_decision_s = hal::seconds(c_.now - c_.session.tracker().since());
  if (chosen) return {Event::GraspChosen, c_.record.decision->decision.reason};
  // a share that was asked for strictly is for whoever asked to relax
  const bool strict = c_.record.decision && c_.record.decision->decision.refused_for_share;
  const bool asked = !strict && requests_.ask(grasps_.judged());
  return {asked ? Event::PartnerAsked : Event::NoGraspFits, c_.attempts.failure};
}

TaskEvent PlanPhase::plan() {
  auto event = find_path();
  c_.session.looked_away(c_.robot.clock->now() - c_.now);
  return event;
}

TaskEvent PlanPhase::find_path() {
  const hal::Timestamp start = c_.stopwatch.now();
  if (auto fault = map_fault(c_.session.map(), c_.session.analysis().cloud, c_.config.map_check))
    return {Event::NoPath, *std::move(fault)};
  const auto to_chosen = [&] {
    return c_.motion_planner.plan(c_.arm.commanded(), c_.chosen(), c_.config.task.lift_height_m);
  };
  // around what obstructed the last path, as far away as the arm would like to pass; else nearer, and in the
  // end no farther than past the partner, in case it is gone before the arm is there
  const double nearest_m = c_.config.motion.scene.partner_clearance_m;
  for (double far_m = c_.obstacle_clearance_m; !c_.obstacles_W.empty() && far_m > nearest_m;
       far_m -= kNearer_m) {
    enter_scene(far_m);
    if (auto plan = to_chosen()) return take(std::move(*plan), start);
  }
  enter_scene(0.0);
  std::string why;
  for (int i = 0; i < c_.config.task.attempts.max_planned_grasps; ++i) {
    auto plan = to_chosen();
    if (plan) return take(std::move(*plan), start);
    why = plan.error().detail;
    // the next best, then
    grasps_.refuse_path(why);
    if (!grasps_.choose()) {
      if (c_.record.decision->decision.refused_for_share) why += "; " + c_.attempts.failure;
      break;
    }
  }
  c_.record.timing.plan_ms = 1e3 * hal::seconds(c_.stopwatch.now() - start);
  return {Event::NoPath, why};
}

void PlanPhase::enter_scene(double obstacle_clearance_m) {
  std::vector<Eigen::Vector3f> people = c_.session.partner_points();
  people.insert(people.end(), c_.obstacles_W.begin(), c_.obstacles_W.end());
  const auto& grid = c_.session.map().grid();
  auto scene = planner::with_partner(*c_.empty_scene, grid, people);
  if (obstacle_clearance_m > c_.config.motion.scene.partner_clearance_m)
    scene = planner::with_obstacle(scene, grid, c_.obstacles_W, obstacle_clearance_m);
  c_.motion_planner.set_scene(std::make_shared<planner::CollisionScene>(std::move(scene)), c_.session.map(),
                              hal::Vec3::UnitZ());
}

TaskEvent PlanPhase::take(planner::MotionPlan plan, hal::Timestamp began) {
  c_.record.timing.plan_ms = 1e3 * hal::seconds(c_.stopwatch.now() - began);
  c_.record.plan = std::move(plan);
  const planner::MotionPlan& p = *c_.record.plan;
  const auto& certificate = c_.record.decision->share.certificate;
  return {c_.options.dry_run ? Event::DryRunOver : Event::PlanReady,
          fmt::format("trajectory of {:.1f} s{}", p.transit.duration_s() + p.approach.duration_s(),
                      certificate ? "; " + certificate->text : "")};
}

}  // namespace colift::control
