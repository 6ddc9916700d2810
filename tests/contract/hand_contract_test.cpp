#include <catch2/catch.hpp>
#include <memory>

#include "barrett_rig.hpp"
#include "barrett_wire_rig.hpp"
#include "colift/contract/hand_contract.hpp"
#include "hal/guards/guarded_hand.hpp"
#include "sim_hal/mock/mock_hand.hpp"
#include "sim_rig.hpp"

namespace colift {
namespace {

sim_hal::HandScript script(bool with_object) {
  sim_hal::HandScript s;
  if (with_object) s.contact_rad = [](hal::Timestamp) { return sim_hal::FingerAngles{1.2, 1.2, 1.18}; };
  return s;
}

// A hand with something between its fingers, or with nothing, and what moves time for it.
struct MockRig {
  explicit MockRig(bool with_object)
      : hand(std::make_unique<sim_hal::MockHand>(script(with_object), clock)) {}
  void pass(hal::Duration by) { clock.advance(by); }
  hal::ManualClock clock;
  std::unique_ptr<hal::Hand> hand;
};

struct SimRig {
  explicit SimRig(bool with_object)
      : world(contract_world(with_object)), hand(sim_hal::make_sim_hand(*world)) {}
  void pass(hal::Duration by) { world->advance(by); }
  std::unique_ptr<sim_hal::SimWorld> world;
  std::unique_ptr<hal::Hand> hand;
};

struct GuardedMockRig {
  explicit GuardedMockRig(bool with_object)
      : hand(std::make_unique<hal::GuardedHand>(
            std::make_unique<sim_hal::MockHand>(script(with_object), clock), hal::HandGuardConfig{})) {}
  void pass(hal::Duration by) { clock.advance(by); }
  hal::ManualClock clock;
  std::unique_ptr<hal::Hand> hand;
};

}  // namespace

#ifdef COLIFT_CONTRACT_ON_VCAN  // in a machine whose kernel has CAN: tests/can_vm
#define COLIFT_HANDS SocketcanRig
#else
#define COLIFT_HANDS MockRig, SimRig, BarrettRig, SocketcandRig, GuardedMockRig
#endif

TEMPLATE_TEST_CASE("a hand keeps its contract", "[hand][contract]", COLIFT_HANDS) {
  contract::check_hand([](bool with_object) {
    auto rig = std::make_shared<TestType>(with_object);
    return contract::HandUnderTest{rig, rig->hand.get(), [r = rig.get()](hal::Duration by) { r->pass(by); }};
  });
}

}  // namespace colift
