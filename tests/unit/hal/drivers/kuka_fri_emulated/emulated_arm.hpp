#pragma once

#include <catch2/catch.hpp>
#include <memory>
#include <string>

#include "hal/drivers/kuka_fri/fri_arm.hpp"
#include "hal/guards/guarded_arm.hpp"
#include "sim_hal/emulator/krc/krc_lock_step.hpp"
#include "sim_hal/emulator/krc/plant/krc_light_plant.hpp"

namespace colift::test {

inline constexpr hal::Endpoint kKrc{0x7F000001, 49152}, kPc{0x7F000001, 49938};

/// The driver and the emulated controller, in lock step with a clock of the test.
struct Emulated {
  hal::ManualClock clock;
  sim_hal::MemoryWire wire{clock};
  hal::ArmDynamics dynamics{hal::built_in_robot(), hal::ArmDynamics::Load::Hand};
  std::unique_ptr<sim_hal::LightPlant> plant;
  std::unique_ptr<hal::DatagramLink> end;
  std::unique_ptr<sim_hal::KrcEmulator> krc;
  std::string told;
  hal::FriArm* fri = nullptr;
  std::unique_ptr<hal::Arm> arm;

  explicit Emulated(const std::string& script, hal::FriConfig config = {}, sim_hal::KrcConfig krc_config = {},
                    bool guarded = true) {
    sim_hal::LightPlantConfig p;
    p.start_rad << 0.1, 0.35, -0.2, 1.4, 0.1, -0.9, 0.3;
    plant = std::make_unique<sim_hal::LightPlant>(dynamics, p);
    end = wire.end(kKrc);
    REQUIRE(end->open());
    krc_config.script = script;
    krc = std::make_unique<sim_hal::KrcEmulator>(
        krc_config, dynamics, *plant, *end,
        [this](double t, const std::string& text) { told += std::to_string(t) + " " + text + "\n"; });
    REQUIRE(krc->start(clock.now()));
    config.script = script;
    auto driver =
        std::make_unique<hal::FriArm>(config, wire.end(kPc, sim_hal::lock_step(*krc, clock)), clock);
    fri = driver.get();
    if (guarded)
      arm = std::make_unique<hal::GuardedArm>(std::move(driver), hal::built_in_robot(), hal::GuardConfig{});
    else
      arm = std::move(driver);
  }

  [[nodiscard]] std::string broken() const {
    std::string text;
    for (const auto& b : krc->report().broken_rules)
      text += std::to_string(b.t) + " " + std::string(name(b.rule)) + ": " + b.reason + "\n";
    return text;
  }
};

}  // namespace colift::test
