#pragma once

#include <catch2/catch.hpp>
#include <chrono>
#include <functional>
#include <memory>

#include "hal/drivers/barrett_can/barrett_hand.hpp"
#include "hal/drivers/barrett_can/pucks/puck_codec.hpp"
#include "hal/os/make_can_bus.hpp"
#include "sim_hal/emulator/hand/hand_gateway.hpp"
#include "sim_hal/emulator/hand/hand_light_plant.hpp"
#include "sim_hal/emulator/hand/hand_lock_step.hpp"
#include "tools/rig/lock_step/stepped_can.hpp"

namespace colift {

/// As BarrettRig, the bus between driver and pucks being a real one: Wire::far_end() is what the pucks have,
/// Wire::name(far end) what the driver's config would call it.
template <class Wire>
struct BarrettWireRig {
  hal::ManualClock clock;
  std::unique_ptr<typename Wire::FarEnd> inner = Wire::far_end();
  typename Wire::FarEnd& wire = *inner;
  SteppedCan far_end{std::move(inner), clock};
  sim_hal::LightHandPlant plant;
  sim_hal::HandEmulator pucks;
  std::unique_ptr<SteppedCan> client;
  std::unique_ptr<hal::Hand> hand;

  explicit BarrettWireRig(bool with_object) : pucks({}, plant, far_end) {
    const auto opened = far_end.open();
    INFO((opened ? std::string() : opened.error().text()));
    REQUIRE(opened);
    REQUIRE(pucks.start(clock.now()));
    const auto filters = hal::barrett::hand_filters();
    auto bus = hal::make_can_bus(Wire::name(wire), {filters.begin(), filters.end()});
    REQUIRE(bus);
    client = std::make_unique<SteppedCan>(std::move(*bus), clock);
    client->join(far_end);
    client->while_waiting = sim_hal::lock_step(pucks, clock);
    if (with_object) plant.put(sim_hal::HandObject::of_width(0.10));
    hand = std::make_unique<hal::BarrettHand>(*client, hal::BarrettHandConfig{}, clock);
  }

  void pass(hal::Duration by) {
    const hal::Timestamp end = clock.now() + by;
    while (clock.now() < end) {
      sim_hal::run_until(pucks, clock,
                         std::min<hal::Timestamp>(end, clock.now() + std::chrono::milliseconds(1)));
      (void)hand->state();
    }
    REQUIRE(client->lost() + far_end.lost() == 0);
  }
};

/// On a virtual interface of this kernel.
struct OverSocketcan {
  using FarEnd = hal::CanBus;
  static constexpr const char* kName = "socketcan:vcan0";
  static std::unique_ptr<FarEnd> far_end() { return std::move(*hal::make_can_bus(kName)); }
  static std::string name(const FarEnd&) { return kName; }
};

/// Over TCP on loopback.
struct OverSocketcand {
  using FarEnd = sim_hal::HandGateway;
  static std::unique_ptr<FarEnd> far_end() {
    return std::make_unique<FarEnd>(sim_hal::HandGatewayConfig{"127.0.0.1", 0, "can0"});
  }
  static std::string name(const FarEnd& gateway) {
    return "socketcand:127.0.0.1:" + std::to_string(gateway.port()) + "/can0";
  }
};

using SocketcanRig = BarrettWireRig<OverSocketcan>;
using SocketcandRig = BarrettWireRig<OverSocketcand>;

}  // namespace colift
