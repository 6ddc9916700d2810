// Opens an arm, gets it into command mode, holds it for a second and lets it go: the whole life of a device.
// Here the arm is simulated, with gravity and joint torques; hal::make_kuka_arm() gives a real one, and
// nothing else changes but that its cycles come in real time.
//
//   build/example_04_hold_an_arm

#include <fmt/format.h>

#include <algorithm>

#include "hal/guards/guarded_arm.hpp"
#include "sim_hal/mujoco/devices/sim_devices.hpp"

int main() {
  using namespace colift;
  const hal::RobotModel& model = hal::built_in_robot();
  auto world = sim_hal::SimWorld::make(sim_hal::built_in_scenario(), model, /*seed=*/1, sim_hal::SimConfig{});
  if (!world) return fmt::print(stderr, "{}\n", world.error().text()), 2;
  // every command passes the guard, on the robot as here
  hal::GuardedArm arm(sim_hal::make_sim_arm(**world), model, hal::GuardConfig{});

  for (const auto& step : {arm.configure(), arm.activate()})
    if (!step) return fmt::print(stderr, "{}\n", step.error().text()), 2;

  hal::ImpedanceCommand command;
  command.stiffness_nm_rad.setConstant(800.0);
  double drift_rad = 0.0, torque_nm = 0.0;
  for (int cycle = 0; cycle < 200; ++cycle) {
    const auto state = arm.wait_cycle();  // the arm's controller is the clock
    if (!state) return fmt::print(stderr, "{}\n", state.error().text()), 1;
    if (cycle == 0) command.q_rad = state->q_rad;  // hold what was measured first
    if (auto sent = arm.command(command); !sent) return fmt::print(stderr, "{}\n", sent.error().text()), 1;
    drift_rad = std::max(drift_rad, (state->q_rad - command.q_rad).cwiseAbs().maxCoeff());
    torque_nm = std::max(torque_nm, state->tau_nm.cwiseAbs().maxCoeff());
  }
  arm.deactivate();

  const hal::DeviceHealth health = arm.health();
  fmt::print(
      "held for 200 cycles: drift {:.2f} mrad, max joint torque {:.1f} N m, {} states used, {} dropped\n",
      1e3 * drift_rad, torque_nm, health.accepted, health.rejected);
  return drift_rad < 0.005 && health.accepted >= 200 && health.rejected == 0 ? 0 : 1;
}
