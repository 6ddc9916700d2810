#include "tools/experiments/runs/whole_lift.hpp"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "control/task/run_job.hpp"
#include "hal/guards/guarded_arm.hpp"
#include "hal/guards/guarded_hand.hpp"
#include "hal/types/units.hpp"
#include "sim_hal/imperfect/imperfect_devices.hpp"
#include "sim_hal/judge/judge.hpp"
#include "sim_hal/mujoco/devices/sim_devices.hpp"
#include "tools/experiments/trials/sighting.hpp"

namespace colift::experiments {

hal::Result<WholeLift> run_whole_lift(const sim_hal::Scenario& scenario, control::Method method,
                                      std::uint64_t seed, const LiftHooks& with) {
  const hal::RobotModel& model = hal::built_in_robot();
  auto world = sim_hal::SimWorld::make(scenario, model, seed, sim_hal::SimConfig{});
  if (!world) return tl::unexpected(world.error());
  sim_hal::Judge judge(model, /*exact_time=*/true);
  (*world)->observe([&](const sim_hal::TickReport& report) {
    judge.tick(report);
    if (with.each_tick) with.each_tick(report);
  });
  control::Config config = config_for(
      method, control::TaskSaid{"scenario " + scenario.name, scenario.task.height, scenario.task.hold_s},
      with.settings);
  if (with.without_monitor) config.monitor.on = config.monitor.force.on = false;
  if (with.started) with.started(**world);
  hal::Robot robot;
  auto arm = sim_hal::make_sim_arm(**world);
  auto hand = sim_hal::make_sim_hand(**world);
  robot.camera = sim_hal::make_sim_camera(**world);
  robot.more_cameras = sim_hal::make_more_sim_cameras(**world);
  hal::Pose X_WC = sim_hal::camera_pose(scenario.camera);
  if (with.errors) {
    arm = sim_hal::make_imperfect_arm(std::move(arm), model, with.errors->arm);
    hand = sim_hal::make_imperfect_hand(std::move(hand), with.errors->hand);
    robot.camera = sim_hal::make_imperfect_camera(std::move(robot.camera), with.errors->camera);
    X_WC = X_WC * with.errors->camera.X_CK;
  }
  robot.arm = std::make_unique<hal::GuardedArm>(std::move(arm), model, config.guard_arm);
  robot.hand = std::make_unique<hal::GuardedHand>(std::move(hand), config.guard_hand);
  robot.clock = sim_hal::make_sim_clock(**world);
  const control::RigView rig{model, shared_hand(method).hand, shared_hand(method).tables, X_WC,
                             sim_hal::more_camera_poses(scenario)};
  const hal::SteadyClock wall;
  control::JobOptions options;
  options.method = method;
  options.seed = seed;

  WholeLift lift;
  int n = 0;
  double tilt = 0.0, height = 0.0, share = 0.0, slip = 0.0;
  control::JobHooks hooks;
  bool enough = false, held = false;
  const auto entered = [&](control::Task state) {
    const std::string name(control::word(state));
    (*world)->task_state(name);
    judge.task_state(name);
  };
  hooks.started = [&] { entered(control::Task::Observe); };
  hooks.changed = [&](control::Task from, control::Task to) {
    entered(to);
    const bool lifted = from == control::Task::Lower;
    const bool let_go = !std::isnan(lift.let_go_s);
    enough = enough || std::find(with.cut.at.begin(), with.cut.at.end(), to) != with.cut.at.end();
    enough = enough || (with.cut.at_release_before_lift && to == control::Task::Release && !lifted && let_go);
  };
  hooks.interrupted = [&] { return enough; };
  hooks.asked = [&](const control::PartnerAsk& ask) { (*world)->ask_partner(ask.grasp_W, ask.aside_W); };
  hooks.status = [&](const control::JobStatus& status) {
    if (with.each_frame) with.each_frame(**world, status.state);
    const sim_hal::SimTruth truth = (*world)->truth();
    if (held && !truth.partner_W && std::isnan(lift.let_go_s)) {
      lift.height_at_let_go_m = truth.height_m;
      lift.let_go_s = hal::seconds(status.now);
    }
    held = truth.partner_W.has_value();
    enough = enough || (status.state == control::Task::Pause &&
                        hal::seconds(status.now - status.since) > with.cut.paused_s);
    if (status.state != control::Task::Hold) return;
    ++n;
    tilt += hal::rad_to_deg(truth.tilt_rad);
    height += truth.height_m;
    slip = std::max(slip, truth.slip_m);
    share += truth.robot_force_W.z() /
             (truth.robot_force_W.z() + truth.partner_force_W.z() + truth.floor_force_W.z());
  };
  auto record = control::run_job(robot, rig, config, options, hooks, wall);
  if (!record) return tl::unexpected(record.error());
  lift.record = std::move(*record);
  if (n > 0) {
    lift.tilt_deg = tilt / n;
    lift.height_m = height / n;
    lift.share_robot = share / n;
    lift.slip_m = slip;
  }
  lift.verdict = judge.verdict(lift.record.outcome == control::RunRecord::Result::Lifted);
  lift.hit_something = (*world)->truth().robot_hit_something;
  if (with.ended) with.ended(lift.record);
  return lift;
}

const char* word(control::RunRecord::Result outcome) {
  switch (outcome) {
    case control::RunRecord::Result::Lifted:
      return "lifted";
    case control::RunRecord::Result::Aborted:
      return "aborted";
    case control::RunRecord::Result::Refused:
      break;
  }
  return "refused";
}

}  // namespace colift::experiments
