#include <catch2/catch.hpp>
#include <memory>

#include "colift/contract/arm_contract.hpp"
#include "fri_rig.hpp"
#include "hal/guards/guarded_arm.hpp"
#include "sim_hal/mock/mock_arm.hpp"

namespace colift {
namespace {

sim_hal::ArmScript script() {
  sim_hal::ArmScript s;
  s.start_rad = palm_ahead_rad();
  return s;
}

// A back end that is ready to be configured, and what it needs to live.
struct MockRig {
  hal::ManualClock clock;
  std::unique_ptr<hal::Arm> arm = std::make_unique<sim_hal::MockArm>(script(), clock);
};

struct SimRig {
  std::unique_ptr<sim_hal::SimWorld> world = contract_world(false);
  std::unique_ptr<hal::Arm> arm = sim_hal::make_sim_arm(*world);
};

struct GuardedMockRig {
  hal::ManualClock clock;
  std::unique_ptr<hal::Arm> arm = std::make_unique<hal::GuardedArm>(
      std::make_unique<sim_hal::MockArm>(script(), clock), hal::built_in_robot(), hal::GuardConfig{});
};

struct GuardedSimRig {
  std::unique_ptr<sim_hal::SimWorld> world = contract_world(false);
  std::unique_ptr<hal::Arm> arm = std::make_unique<hal::GuardedArm>(
      sim_hal::make_sim_arm(*world), hal::built_in_robot(), hal::GuardConfig{});
};

struct GuardedFriRig : FriRig {
  GuardedFriRig() {
    arm = std::make_unique<hal::GuardedArm>(std::move(arm), hal::built_in_robot(), hal::GuardConfig{});
  }
};

}  // namespace

TEMPLATE_TEST_CASE("an arm keeps its contract", "[arm][contract]", MockRig, SimRig, FriRig, GuardedMockRig,
                   GuardedSimRig, GuardedFriRig) {
  contract::ArmTraits traits;
  traits.start_rad = palm_ahead_rad();
  contract::check_arm(
      [] {
        auto rig = std::make_shared<TestType>();
        return contract::ArmUnderTest{rig, rig->arm.get()};
      },
      traits);
}

}  // namespace colift
