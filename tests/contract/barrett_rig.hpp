#pragma once

#include <functional>
#include <memory>

#include "hal/drivers/barrett_can/barrett_hand.hpp"
#include "sim_hal/emulator/hand/hand_light_plant.hpp"
#include "sim_hal/emulator/hand/hand_lock_step.hpp"

namespace colift {

/// The hand's driver with emulated pucks at the far end of a bus in memory, in lock step. In `pass` the
/// driver runs every millisecond, as HandThread lets it on the robot.
struct BarrettRig {
  hal::ManualClock clock;
  sim_hal::MemoryCan bus{clock};
  std::unique_ptr<sim_hal::MemoryCan::Node> far_end = bus.node();
  sim_hal::LightHandPlant plant;
  sim_hal::HandEmulator pucks;
  std::unique_ptr<sim_hal::MemoryCan::Node> client = bus.node(sim_hal::lock_step(pucks, clock));
  hal::BarrettHand* driver = nullptr;
  std::unique_ptr<hal::Hand> hand;

  explicit BarrettRig(bool with_object, const hal::BarrettHandConfig& config = {},
                      const sim_hal::HandEmulatorConfig& emulator = {})
      : pucks(emulator, plant, *far_end) {
    (void)far_end->open();
    (void)pucks.start(clock.now());
    sim_hal::let_faults_reach(pucks, *client);
    if (with_object) plant.put(sim_hal::HandObject::of_width(kObject_m));
    auto barrett = std::make_unique<hal::BarrettHand>(*client, config, clock);
    driver = barrett.get();
    hand = std::move(barrett);
  }

  void pass(hal::Duration by, const std::function<void()>& each_ms = {}) {
    const hal::Timestamp end = clock.now() + by;
    while (clock.now() < end) {
      sim_hal::run_until(pucks, clock,
                         std::min<hal::Timestamp>(end, clock.now() + std::chrono::milliseconds(1)));
      (void)hand->state();
      if (each_ms) each_ms();
    }
  }

  static constexpr double kObject_m = 0.10;
};

}  // namespace colift
