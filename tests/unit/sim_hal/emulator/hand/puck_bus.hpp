#pragma once

#include <catch2/catch.hpp>
#include <initializer_list>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "sim_hal/emulator/hand/hand_light_plant.hpp"
#include "sim_hal/emulator/hand/hand_lock_step.hpp"

namespace colift {

using namespace sim_hal;
using namespace std::chrono_literals;

inline constexpr int kF1 = 0x00b, kF2 = 0x00c, kF3 = 0x00d, kSpreadId = 0x00e, kHand = 0x405;

/// The emulated pucks on a bus in memory, asked byte by byte.
struct Bus {
  hal::ManualClock clock;
  MemoryCan bus{clock};
  std::unique_ptr<MemoryCan::Node> far_end = bus.node(), client = bus.node();
  LightHandPlant plant;
  HandEmulator hand;
  std::vector<hal::CanFrame> heard;

  explicit Bus(HandEmulatorConfig config = awake()) : hand(std::move(config), plant, *far_end) {
    REQUIRE(far_end->open());
    REQUIRE(client->open());
    REQUIRE(hand.start(clock.now()));
  }
  static HandEmulatorConfig awake() {
    HandEmulatorConfig c;
    c.puck.awake = true;
    return c;
  }
  void pass(hal::Duration by) {
    run_until(hand, clock, clock.now() + by);
    hal::CanFrame f;
    while (client->receive(f, 0ns) == hal::CanBus::Received::Frame) heard.push_back(f);
  }
  void say(int id, std::initializer_list<int> bytes) {
    hal::CanFrame f;
    f.id = static_cast<std::uint16_t>(id);
    for (const int b : bytes) f.data[f.length++] = static_cast<std::uint8_t>(b);
    (void)client->send(f);
  }
  void set(int id, int property, int value) {
    say(id, {0x80 | property, 0, value & 255, value >> 8 & 255, value >> 16 & 255, value >> 24 & 255});
    pass(300us);
  }
  std::vector<hal::CanFrame> ask(int id, int property, hal::Duration timeout = 3ms) {
    pass(0ns);
    heard.clear();
    say(id, {property});
    pass(timeout);
    return heard;
  }
  std::optional<int> value(int id, int property) {
    const auto f = ask(id, property);
    if (f.empty()) return std::nullopt;
    REQUIRE(f.size() == 1);
    int v = f[0].data[2] | f[0].data[3] << 8;
    return f[0].length == 6 ? v | f[0].data[4] << 16 | f[0].data[5] << 24 : static_cast<std::int16_t>(v);
  }
  int position(std::size_t p) { return hand.puck(p).position(); }
  int mode(int id) { return value(id, prop::kMode).value_or(-1); }
};

}  // namespace colift
