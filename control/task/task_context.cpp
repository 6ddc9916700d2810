#include "control/task/task_context.hpp"

#include <memory>

namespace colift::control {
// every model that load_robot() lets pass has the arm that arm_geometry() describes
TaskContext::TaskContext(hal::Robot& robot_, const RigView& rig_, const Config& config_,
                         const JobOptions& options_, const hal::Clock& stopwatch_)
    : robot(robot_),
      rig(rig_),
      config(config_),
      options(options_),
      stopwatch(stopwatch_),
      arm(*robot.arm, rig.model, planner::arm_geometry(rig.model).value(), config.task, config.load,
          options.drive, config.setpoints.below(config.guard_arm), config.monitor.force),
      session(options.method, config, rig, stopwatch),
      motion_planner(rig.model, rig.hand, config.motion, options.seed),
      test_lifts(config.test_lift) {
  if (options.recorded_views) arm.play(options.recorded_views);
}

bool TaskContext::follow(const planner::Trajectory& trajectory) {
  if (trajectory.empty()) return true;
  const auto started = arm.follow(trajectory);
  if (!started) attempts.failure = started.error().detail;
  return started.has_value();
}

void TaskContext::note_device(const std::string& device, const std::string& what) {
  record.faults.push_back({now - began, device, what});
}

void TaskContext::see_object(const hal::Pose& X_Wnow_Wscene) {
  const hal::OrientedBox& box = session.analysis().scene.target->obb;
  hal::Pose X_WO = hal::Pose::Identity();
  X_WO.translation() = box.center;
  X_WO.linear() = box.axes;
  tracked.X_WO = X_Wnow_Wscene * X_WO;
}

void TaskContext::use_map() {
  empty_scene = std::make_shared<planner::CollisionScene>(planner::make_collision_scene(
      session.map(), session.analysis().scene.ground->plane, config.motion.scene));
  motion_planner.set_scene(empty_scene, session.map(), hal::Vec3::UnitZ());
  ++map_version;
}

std::size_t TaskContext::renew_map() {
  const std::size_t freed = readings.frame ? session.free_carried_off(*readings.frame) : 0;
  if (freed > 0) use_map();
  return freed;
}

std::optional<double> TaskContext::mass_kg() const {
  if (config.decision.known_mass_kg) return config.decision.known_mass_kg;
  const auto& tested = test_lifts.known();
  if (tested && tested->mass_kg > 0.0) return tested->mass_kg;
  return std::nullopt;
}

const planner::GraspCandidate& TaskContext::chosen() const {
  return record.decision->candidates[*record.decision->decision.chosen];
}

HandLine TaskContext::hand_line() const {
  const planner::GraspCandidate& c = chosen();
  hal::Vec3 line_W = record.decision->partner->position - planner::load_point(c);
  line_W.z() = 0.0;
  // one above the other there is no such line
  return {{0.0, 0.0, rig.hand.gap(c) + c.depth_m}, line_W.stableNormalized()};
}

}  // namespace colift::control
