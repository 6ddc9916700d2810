#pragma once

#include <memory>

#include "hal/drivers/kuka_fri/fri_arm.hpp"
#include "sim_hal/emulator/krc/krc_lock_step.hpp"
#include "sim_hal/emulator/krc/plant/krc_light_plant.hpp"
#include "sim_rig.hpp"

namespace colift {

/// The arm's driver with an emulated controller at the far end of a wire in memory, in lock step.
struct FriRig {
  hal::ManualClock clock;
  sim_hal::MemoryWire wire{clock};
  hal::ArmDynamics dynamics{hal::built_in_robot(), hal::ArmDynamics::Load::Hand};
  sim_hal::LightPlant plant{dynamics, plant_config()};
  std::unique_ptr<hal::DatagramLink> far_end = wire.end({0x7F000001, 49152});
  sim_hal::KrcEmulator krc{sim_hal::KrcConfig{}, dynamics, plant, *far_end};
  std::unique_ptr<hal::Arm> arm = std::make_unique<hal::FriArm>(
      hal::FriConfig{}, wire.end({0x7F000001, 49938}, sim_hal::lock_step(krc, clock)), clock);

  FriRig() {
    (void)far_end->open();
    (void)krc.start(clock.now());
  }
  static sim_hal::LightPlantConfig plant_config() {
    sim_hal::LightPlantConfig config;
    config.start_rad = palm_ahead_rad();
    return config;
  }
};

}  // namespace colift
