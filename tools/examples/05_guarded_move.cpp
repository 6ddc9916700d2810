// Moves one joint by 20 degrees along a jerk-limited trajectory, then asks for a jump that no arm should
// make: the guard does not send it, brakes instead, and says why.
//
//   build/example_05_guarded_move

#include <fmt/format.h>

#include <algorithm>
#include <numbers>
#include <vector>

#include "hal/guards/guarded_arm.hpp"
#include "planner/motion/trajectory/trajectory.hpp"
#include "sim_hal/mujoco/devices/sim_devices.hpp"

int main() {
  using namespace colift;
  constexpr double kDeg = std::numbers::pi / 180.0;
  const hal::RobotModel& model = hal::built_in_robot();
  auto world = sim_hal::SimWorld::make(sim_hal::built_in_scenario(), model, /*seed=*/1, sim_hal::SimConfig{});
  if (!world) return fmt::print(stderr, "{}\n", world.error().text()), 2;
  hal::GuardedArm arm(sim_hal::make_sim_arm(**world), model, hal::GuardConfig{});
  for (const auto& step : {arm.configure(), arm.activate()})
    if (!step) return fmt::print(stderr, "{}\n", step.error().text()), 2;

  auto state = arm.wait_cycle();
  if (!state) return fmt::print(stderr, "{}\n", state.error().text()), 2;
  const hal::Timestamp began = state->measured_at;
  hal::JointVector goal_rad = state->q_rad;
  goal_rad[0] -= 20.0 * kDeg;  // A1, away from the table
  const auto trajectory = planner::make_trajectory(std::vector{state->q_rad, goal_rad},
                                                   planner::MotionLimits{}, /*blend_rad=*/0.0);
  if (!trajectory) return fmt::print(stderr, "{}\n", trajectory.error().text()), 2;
  fmt::print("A1 from {:.1f} to {:.1f} deg in {:.2f} s\n", state->q_rad[0] / kDeg, goal_rad[0] / kDeg,
             trajectory->duration_s());

  hal::ImpedanceCommand command;
  double t_s = 0.0, lag_rad = 0.0;
  while (t_s < trajectory->duration_s() + 0.5) {
    command.q_rad = trajectory->sample(t_s).q_rad;
    if (auto sent = arm.command(command); !sent) return fmt::print(stderr, "{}\n", sent.error().text()), 1;
    if (state = arm.wait_cycle(); !state) return fmt::print(stderr, "{}\n", state.error().text()), 1;
    lag_rad = std::max(lag_rad, (state->q_rad - command.q_rad).cwiseAbs().maxCoeff());
    t_s = hal::seconds(state->measured_at - began);
  }
  const double miss_rad = (state->q_rad - goal_rad).cwiseAbs().maxCoeff();
  fmt::print("arrived within {:.3f} deg; max lag on the path {:.2f} deg\n", miss_rad / kDeg, lag_rad / kDeg);

  command.q_rad[0] += 30.0 * kDeg;  // in one cycle of 5 ms
  const auto jump = arm.command(command);
  fmt::print("a jump of 30 deg: {}\n", jump ? "was sent" : jump.error().text());
  arm.deactivate();
  return miss_rad < 0.5 * kDeg && !jump && jump.error().code == hal::ErrorCode::LimitExceeded ? 0 : 1;
}
