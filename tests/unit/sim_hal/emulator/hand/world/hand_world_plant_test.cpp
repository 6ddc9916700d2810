// The driver, the emulated pucks, and the physics behind them.
#include "sim_hal/emulator/mujoco/hand_world_plant.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <string>

#include "hal/drivers/barrett_can/barrett_hand.hpp"
#include "sim_hal/emulator/hand/hand_lock_step.hpp"
#include "tests/contract/sim_rig.hpp"

using namespace colift;
using namespace std::chrono_literals;

namespace {

struct Rig {
  hal::ManualClock clock;
  std::unique_ptr<sim_hal::SimWorld> world;
  sim_hal::MemoryCan bus{clock};
  std::unique_ptr<sim_hal::MemoryCan::Node> far_end = bus.node();
  sim_hal::HandWorldPlant plant;
  sim_hal::HandEmulator pucks{{}, plant, *far_end};
  std::unique_ptr<sim_hal::MemoryCan::Node> client = bus.node(sim_hal::lock_step(pucks, clock));
  hal::BarrettHand hand{*client, {}, clock};

  // With `arms_cycle` an arm's controller moves the world, that much at once.
  explicit Rig(bool post_in_hand, hal::Duration arms_cycle = 0ms)
      : world(contract_world(post_in_hand)),
        plant(*world, {.moves_world = arms_cycle == 0ms, .tip_units_nm = 2900.0}) {
    if (arms_cycle > 0ms)
      bus.tap = [this, arms_cycle](const hal::CanFrame&) {
        while (world->elapsed() + arms_cycle <= clock.now()) world->advance(arms_cycle);
      };
    (void)far_end->open();
    REQUIRE(pucks.start(clock.now()));
    const auto done = hand.configure();
    INFO((done ? std::string() : done.error().text()));
    REQUIRE(done);
    REQUIRE(hand.activate());
  }
  void pass(hal::Duration by) {
    const hal::Timestamp end = clock.now() + by;
    while (clock.now() < end) {
      sim_hal::run_until(pucks, clock, std::min<hal::Timestamp>(end, clock.now() + 1ms));
      (void)hand.state();
    }
  }
  hal::HandState look() {
    const auto state = hand.state();
    INFO((state ? std::string() : state.error().text()));
    REQUIRE(state);
    return *state;
  }
  hal::HandState settle() {
    for (int i = 0; i < 800 && look().moving; ++i) pass(10ms);
    REQUIRE_FALSE(look().moving);
    return look();
  }
};

}  // namespace

TEST_CASE("the driver grips a post of the simulated world and lets go", "[hand][emulator][world]") {
  Rig rig(true);
  REQUIRE(rig.hand.preshape(0.4));
  CHECK(rig.settle().spread_rad == Approx(0.4).margin(0.02));
  REQUIRE(rig.hand.close(0.7));
  rig.pass(200ms);
  CHECK(rig.look().moving);
  const auto held = rig.settle();
  INFO(rig.hand.report().why.str());
  REQUIRE(held.held);
  for (std::size_t f = 0; f < 3; ++f) {
    CHECK(held.finger_rad[f] > 0.5);
    CHECK(held.finger_rad[f] < 2.0);
    // what the driver reads over the bus is what the world has
    CHECK(held.finger_rad[f] == Approx(rig.world->hand_state().finger_rad[f]).margin(0.03));
  }
  CHECK(rig.world->truth().robot_touches_object);
  rig.pass(2s);
  CHECK(rig.look().held);
  REQUIRE(rig.hand.release());
  const auto open = rig.settle();
  for (const double angle : open.finger_rad) CHECK(std::abs(angle) < 0.02);
  CHECK_FALSE(rig.world->truth().robot_touches_object);
}

TEST_CASE("it grips as well when the arm's controller moves the world", "[hand][emulator][world]") {
  Rig rig(true, 5ms);
  REQUIRE(rig.hand.close(1.0));
  const auto held = rig.settle();
  INFO(rig.hand.report().why.str());
  REQUIRE(held.held);
  // F3 bears what both others press, and no more than was wished; beyond 1.14 N m its puck would let off
  for (const double strain_nm : held.torque_nm) CHECK(strain_nm < 1.1);
  rig.pass(1s);
  CHECK(rig.look().held);
  REQUIRE(rig.hand.release());
  for (const double angle : rig.settle().finger_rad) CHECK(std::abs(angle) < 0.02);
}

TEST_CASE("closing around nothing ends at the stops", "[hand][emulator][world]") {
  Rig rig(false);
  REQUIRE(rig.hand.close(0.7));
  const auto state = rig.settle();
  CHECK_FALSE(state.held);
  for (const double angle : state.finger_rad) CHECK(angle > 1.5);
}

TEST_CASE("a hand that is stopped on its way stays there in the world, too", "[hand][emulator][world]") {
  Rig rig(false);
  REQUIRE(rig.hand.close(0.7));
  rig.pass(500ms);
  rig.hand.stop();
  rig.pass(300ms);
  const double here = rig.world->hand_state().finger_rad[0];
  CHECK(here > 0.2);
  CHECK(here < 1.5);
  rig.pass(1s);
  CHECK(rig.world->hand_state().finger_rad[0] == Approx(here).margin(0.01));
  CHECK(rig.look().finger_rad[0] == Approx(here).margin(0.02));
}
