#pragma once

#include <functional>
#include <memory>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "hal/arm.hpp"
#include "hal/drivers/barrett_can/barrett_hand.hpp"
#include "hal/drivers/barrett_can/pucks/puck_codec.hpp"
#include "hal/os/make_can_bus.hpp"
#include "sim_hal/emulator/hand/hand_lock_step.hpp"
#include "sim_hal/emulator/mujoco/hand_world_plant.hpp"
#include "sim_hal/mujoco/sim_world.hpp"
#include "tools/rig/lock_step/stepped_can.hpp"

namespace colift::tools {

/// The hand's real driver and the emulated pucks on a simulated world, joined by a CAN bus in memory or by
/// one of this machine. In lock step: an arm's cycle moves the world by whole milliseconds, then pucks, bus
/// and driver catch up, the driver once a millisecond as HandThread lets it; where the driver waits
/// (start-up), the world comes along.
struct HandWire {
  /// `on`: the bus of both ends as a robot file names it, socketcan:vcan0; empty: in memory. Faults of the
  /// client's end reach a bus in memory only.
  HandWire(sim_hal::SimWorld& the_world, std::uint64_t seed, const std::string& on = {})
      : world(the_world), far_end(far_end_on(on)), plant(the_world), pucks(config(seed), plant, *far_end) {
    const auto wait = [this, step = sim_hal::lock_step(pucks, clock)](hal::Timestamp until) {
      const bool more = step(until);
      while (world.clock().now() + kTick <= clock.now()) world.advance(kTick);
      return more;
    };
    if (on.empty()) {
      auto node = bus.node(wait);
      sim_hal::let_faults_reach(pucks, *node);
      client = std::move(node);
    } else {
      const auto filters = hal::barrett::hand_filters();
      auto near = std::make_unique<SteppedCan>(real(on, {filters.begin(), filters.end()}), clock);
      auto& far = static_cast<SteppedCan&>(*far_end);
      near->join(far);
      near->while_waiting = wait;
      frames_lost = [&far, &near = *near] { return far.lost() + near.lost(); };
      client = std::move(near);
    }
    if (auto opened = far_end->open(); !opened) throw std::runtime_error(opened.error().text());
    (void)pucks.start(clock.now());
  }

  static sim_hal::HandEmulatorConfig config(std::uint64_t seed) {
    sim_hal::HandEmulatorConfig c;
    c.seed = seed;
    return c;
  }

  /// Time without a client.
  void let_pass(hal::Duration by) {
    driver = nullptr;
    for (const hal::Timestamp until = world.clock().now() + by; world.clock().now() < until;) {
      world.advance(kTick);
      catch_up();
    }
  }

  /// The driver, one at a time; to be run by an arm() of this wire.
  [[nodiscard]] std::unique_ptr<hal::BarrettHand> hand() {
    auto made = std::make_unique<hal::BarrettHand>(*client, hal::BarrettHandConfig{}, clock);
    driver = made.get();
    return made;
  }

  /// `inner`, whose cycles let the hand live.
  [[nodiscard]] std::unique_ptr<hal::Arm> arm(std::unique_ptr<hal::Arm> inner) {
    return std::make_unique<Arm>(*this, std::move(inner));
  }

  hal::ManualClock clock;  ///< Of everything; the world's own is never more than a millisecond away.
  sim_hal::SimWorld& world;
  sim_hal::MemoryCan bus{clock};
  std::unique_ptr<hal::CanBus> far_end;
  sim_hal::HandWorldPlant plant;
  sim_hal::HandEmulator pucks;
  std::unique_ptr<hal::CanBus> client;
  std::function<int()> frames_lost = [] { return 0; };  ///< That a real bus did not bring.
  hal::BarrettHand* driver = nullptr;

 private:
  static constexpr hal::Duration kTick = std::chrono::milliseconds(1);

  static std::unique_ptr<hal::CanBus> real(const std::string& name,
                                           std::vector<hal::CanFilter> filters = {}) {
    auto made = hal::make_can_bus(name, std::move(filters));
    if (!made) throw std::runtime_error(made.error().text());
    return std::move(*made);
  }
  std::unique_ptr<hal::CanBus> far_end_on(const std::string& name) {
    if (name.empty()) return bus.node();
    return std::make_unique<SteppedCan>(real(name), clock);
  }

  void catch_up() {
    while (clock.now() < world.clock().now()) {
      sim_hal::run_until(pucks, clock, std::min(clock.now() + kTick, world.clock().now()));
      if (driver != nullptr) (void)driver->state();
    }
  }

  class Arm final : public hal::Arm {
   public:
    Arm(HandWire& wire, std::unique_ptr<hal::Arm> inner) : wire_(wire), inner_(std::move(inner)) {}
    hal::Result<> configure() override { return inner_->configure(); }
    hal::Result<> activate() override { return inner_->activate(); }
    void deactivate() noexcept override { inner_->deactivate(); }
    [[nodiscard]] hal::DeviceHealth health() const override { return inner_->health(); }
    hal::Result<hal::ArmState> wait_cycle() override {
      auto state = inner_->wait_cycle();
      wire_.catch_up();
      return state;
    }
    hal::Result<> command(const hal::ImpedanceCommand& command) override { return inner_->command(command); }
    [[nodiscard]] hal::ArmAbilities abilities() const override { return inner_->abilities(); }
    void stop() noexcept override { inner_->stop(); }

   private:
    HandWire& wire_;
    std::unique_ptr<hal::Arm> inner_;
  };
};

}  // namespace colift::tools
