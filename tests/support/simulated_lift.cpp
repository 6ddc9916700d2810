#include "tests/support/simulated_lift.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>

#include "control/task_runner.hpp"
#include "hal/guarded_arm.hpp"
#include "hal/guarded_hand.hpp"
#include "sim_hal/mujoco/sim_devices.hpp"
#include "tests/support/arm_wire.hpp"

namespace colift::tests {
SimulatedLift simulate(const sim_hal::Scenario& scenario, control::Method method, std::uint64_t seed,
                       control::Config config, const std::optional<OverWire>& over) {
  const hal::RobotModel& model = hal::built_in_robot();
  sim_hal::SimConfig sim;
  if (over) sim.arm_period = ArmWire::kCycle;
  auto made = sim_hal::SimWorld::make(scenario, model, seed, sim);
  if (!made) throw std::runtime_error(made.error().text());
  const std::unique_ptr<sim_hal::SimWorld> world = std::move(*made);
  std::unique_ptr<ArmWire> wire;
  if (over) wire = std::make_unique<ArmWire>(*world, seed, std::vector<sim_hal::KrcFault>{});
  hal::Robot robot;
  std::unique_ptr<hal::Arm> arm;
  if (wire)
    arm = wire->arm();
  else
    arm = sim_hal::make_sim_arm(*world);
  robot.arm = std::make_unique<hal::GuardedArm>(std::move(arm), model, config.guard_arm);
  robot.hand = std::make_unique<hal::GuardedHand>(sim_hal::make_sim_hand(*world), config.guard_hand);
  robot.camera = sim_hal::make_sim_camera(*world);
  if (wire)
    robot.clock = std::make_unique<WireClock>(wire->clock);
  else
    robot.clock = sim_hal::make_sim_clock(*world);

  config.task.lift_height_m = scenario.task.height;
  config.task.hold_s = scenario.task.hold_s;
  if (method == control::Method::Thesis) {
    config.decision.weights = planner::SharingWeights::thesis();
    config.decision.max_sideways = std::numeric_limits<double>::infinity();
  }
  const planner::HandModel hand;
  const auto tables = std::make_shared<planner::HandCollision>(hand, config.candidates.collision);
  const hal::SteadyClock wall;
  const control::RigView rig{model, hand, tables, sim_hal::camera_pose(scenario.camera)};
  control::TaskRunner runner(robot, rig, config, {method, seed, false, world->truth().mass_kg}, wall);

  SimulatedLift lift;
  std::optional<hal::Vec3> partner;
  int n = 0;
  double tilt = 0, height = 0, share = 0, slip = 0;
  control::JobHooks hooks;
  hooks.status = [&](const control::JobStatus& status) {
    const sim_hal::SimTruth truth = world->truth();
    const bool decided = status.state == control::Task::Plan || status.state == control::Task::Approach;
    if (status.state == control::Task::Decide || (decided && !partner)) partner = truth.partner_W;
    if (status.state != control::Task::Hold) return;
    ++n;
    tilt += truth.tilt_rad * 180.0 / std::numbers::pi;
    height += truth.height_m;
    slip = std::max(slip, truth.slip_m);
    share += truth.robot_force_W.z() /
             (truth.robot_force_W.z() + truth.partner_force_W.z() + truth.floor_force_W.z());
  };
  std::vector<OverWire::Fault> to_come = over ? over->faults : std::vector<OverWire::Fault>{};
  hooks.changed = [&](control::Task, control::Task to) {
    std::erase_if(to_come, [&](const OverWire::Fault& f) {
      if (f.in != to) return false;
      sim_hal::KrcFault fault = f.fault;
      fault.at_s += hal::seconds(wire->clock.now());
      wire->krc.inject(fault);
      return true;
    });
  };
  auto record = runner.run(hooks);
  if (!record) throw std::runtime_error(record.error().text());
  lift.record = std::move(*record);
  if (n > 0) {
    lift.tilt_deg = tilt / n;
    lift.height_m = height / n;
    lift.share_robot = share / n;
    lift.slip_m = slip;
  }
  if (partner && lift.record.decision && lift.record.decision->partner)
    lift.partner_error_m = (lift.record.decision->partner->position - *partner).norm();
  lift.at_end = world->truth();
  lift.hit_something = lift.at_end.robot_hit_something;
  if (wire) lift.wire = wire->krc.report();
  return lift;
}

double quantile(std::vector<double> values, double p) {
  std::erase_if(values, [](double v) { return std::isnan(v); });
  if (values.empty()) return NAN;
  std::sort(values.begin(), values.end());
  const double at = p * static_cast<double>(values.size() - 1);
  const auto low = static_cast<std::size_t>(at);
  const std::size_t high = std::min(low + 1, values.size() - 1);
  return values[low] + (at - std::floor(at)) * (values[high] - values[low]);
}

}  // namespace colift::tests
