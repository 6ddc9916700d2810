// A scenario of one's own, from its description to a finished lift: a shelf board on the floor, a person who
// takes its far end after two seconds, physics, a noisy camera. `colift run --scenario FILE` does the same
// with the same text in a file.
//
//   build/example_07_own_scenario

#include <fmt/format.h>

#include "control/config/resolve_config.hpp"
#include "control/task/run_job.hpp"
#include "hal/guards/guarded_arm.hpp"
#include "hal/guards/guarded_hand.hpp"
#include "sim_hal/mujoco/devices/sim_devices.hpp"

constexpr const char* kBeam = R"(
schema: colift.scenario/1
object: {kind: box, size: [0.95, 0.14, 0.22], mass: 3.0, pose: {xyz: [1.14, 0.02, 0.0], yaw_deg: 5}, friction: 0.7}
camera: {xyz: [2.1, -1.4, 1.5], look_at: [1.15, 0.0, 0.3], noise: kinect}
partner: {kind: compliant, grasp: [0.475, 0.0, 0.18], arrives_s: 2.0}
task: {kind: lift, height: 0.05, hold_s: 1.0}
)";

int main() {
  using namespace colift;
  const auto scenario = sim_hal::parse_scenario(kBeam, "a beam");
  if (!scenario) return fmt::print(stderr, "{}\n", scenario.error().text()), 2;
  const hal::RobotModel& model = hal::built_in_robot();
  constexpr std::uint64_t kSeed = 4;
  auto world = sim_hal::SimWorld::make(*scenario, model, kSeed, sim_hal::SimConfig{});
  if (!world) return fmt::print(stderr, "{}\n", world.error().text()), 2;

  control::ConfigRequest request;
  request.task = {"scenario a beam", scenario->task.height, scenario->task.hold_s};
  const auto resolved = control::resolve_config(request);
  if (!resolved) return fmt::print(stderr, "{}\n", resolved.error().text()), 2;
  const control::Config& config = resolved->config;
  hal::Robot robot;
  robot.arm = std::make_unique<hal::GuardedArm>(sim_hal::make_sim_arm(**world), model, config.guard_arm);
  robot.hand = std::make_unique<hal::GuardedHand>(sim_hal::make_sim_hand(**world), config.guard_hand);
  robot.camera = sim_hal::make_sim_camera(**world);
  robot.clock = sim_hal::make_sim_clock(**world);
  const planner::HandModel hand;
  const auto tables = std::make_shared<planner::HandCollision>(hand, config.candidates.collision);
  const control::RigView rig{model, hand, tables, sim_hal::camera_pose(scenario->camera)};

  control::JobOptions options;
  options.seed = kSeed;
  double share = NAN;  // the true one, at the top
  control::JobHooks hooks;
  hooks.status = [&](const control::JobStatus& status) {
    if (status.state != control::Task::Hold) return;
    const sim_hal::SimTruth truth = (*world)->truth();
    share = truth.robot_force_W.z() / (truth.robot_force_W.z() + truth.partner_force_W.z());
  };
  const auto record = control::run_job(robot, rig, config, options, hooks, hal::SteadyClock());
  if (!record) return fmt::print(stderr, "{}\n", record.error().text()), 2;

  for (const control::StateChange& change : record->states)
    fmt::print("{:6.2f} s  {:13} {}\n", hal::seconds(change.at), control::word(change.state), change.reason);
  if (record->lift)
    fmt::print(
        "lifted by {:.0f} mm; the robot carried {:.0f} % of it (decided: {:.0f} %, measured: {:.0f} %)\n",
        1e3 * record->lift->height_m, 100 * share, 100 * record->lift->share_predicted,
        100 * record->lift->share_robot);
  return record->outcome == control::RunRecord::Result::Lifted ? 0 : 1;
}
