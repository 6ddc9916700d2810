#pragma once

#include <memory>
#include <vector>

#include "hal/drivers/kuka_fri/fri_arm.hpp"
#include "sim_hal/emulator/krc/krc_lock_step.hpp"
#include "sim_hal/emulator/mujoco/krc_world_plant.hpp"
#include "sim_hal/mujoco/sim_world.hpp"

namespace colift::tools {

/// The arm's real driver and the emulated controller on a simulated world, joined by a wire in memory. In
/// lock step: whoever waits for the arm moves the controller, the world and the clock.
struct ArmWire {
  static constexpr hal::Duration kCycle = std::chrono::milliseconds(2);

  ArmWire(sim_hal::SimWorld& world, const sim_hal::KrcConfig& config)
      : dynamics(world.model(), hal::ArmDynamics::Load::Hand),
        plant(world, dynamics),
        krc(paced(config), dynamics, plant, *far_end,
            [this](double t, const std::string& text) { events.emplace_back(t, text); }) {
    (void)far_end->open();
    (void)krc.start(clock.now());
  }

  [[nodiscard]] std::unique_ptr<hal::FriArm> arm() {
    return std::make_unique<hal::FriArm>(
        hal::FriConfig{}, wire.end({0x7F000001, 49938}, sim_hal::lock_step(krc, clock)), clock);
  }

  /// Time without a client.
  void let_pass(hal::Duration by) { sim_hal::run_until(krc, clock, clock.now() + by); }

  static sim_hal::KrcConfig paced(sim_hal::KrcConfig c) {
    c.cycle = kCycle;
    return c;
  }

  hal::ManualClock clock;
  sim_hal::MemoryWire wire{clock};
  std::unique_ptr<hal::DatagramLink> far_end = wire.end({0x7F000001, 49152});
  hal::ArmDynamics dynamics;
  sim_hal::KrcWorldPlant plant;
  std::vector<std::pair<double, std::string>> events;
  sim_hal::KrcEmulator krc;
};

/// The wire's clock as a robot's.
class WireClock final : public hal::Clock {
 public:
  explicit WireClock(const hal::Clock& clock) : clock_(clock) {}
  [[nodiscard]] hal::Timestamp now() const override { return clock_.now(); }

 private:
  const hal::Clock& clock_;
};

}  // namespace colift::tools
