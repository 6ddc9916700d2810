#include <catch2/catch.hpp>
#include <chrono>
#include <memory>
#include <vector>

#include "fri_rig.hpp"
#include "hal/guards/guarded_arm.hpp"
#include "sim_hal/mock/mock_arm.hpp"

namespace colift {
namespace {

using hal::ErrorCode;
using hal::JointVector;

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

constexpr double kStill_rad = 0.003;  // a simulated arm gives way a little under its own weight
constexpr double kMove_rad = 0.10;
constexpr int kRamp = 200;

hal::ArmState next(hal::Arm& arm) {
  auto state = arm.wait_cycle();
  REQUIRE(state);
  return *state;
}

/// Commands that lead A2 smoothly from `from` by kMove_rad in kRamp cycles; returns every measured state.
std::vector<hal::ArmState> move(hal::Arm& arm, const JointVector& from, int cycles = kRamp) {
  std::vector<hal::ArmState> states;
  for (int i = 0; i < cycles; ++i) {
    states.push_back(next(arm));
    const double s = static_cast<double>(i) / kRamp;
    hal::ImpedanceCommand command;
    command.q_rad = from;
    command.q_rad[1] += kMove_rad * s * s * s * (10.0 + s * (6.0 * s - 15.0));
    REQUIRE(arm.command(command));
  }
  return states;
}

JointVector activate(hal::Arm& arm) {
  REQUIRE(arm.configure());
  REQUIRE(arm.activate());
  return next(arm).q_rad;
}

double apart(const JointVector& a, const JointVector& b) {
  return (a - b).cwiseAbs().maxCoeff();
}

}  // namespace

#define COLIFT_ARMS MockRig, SimRig, FriRig, GuardedMockRig, GuardedSimRig, GuardedFriRig

TEMPLATE_TEST_CASE("an arm tells nothing and does nothing before it is configured", "[arm][contract]",
                   COLIFT_ARMS) {
  TestType rig;
  const auto state = rig.arm->wait_cycle();
  REQUIRE_FALSE(state);
  CHECK(state.error().code == ErrorCode::NotReady);
  CHECK_FALSE(state.error().detail.empty());
  const auto command = rig.arm->command({});
  REQUIRE_FALSE(command);
  CHECK(command.error().code == ErrorCode::NotReady);
  const auto active = rig.arm->activate();
  REQUIRE_FALSE(active);
  CHECK(active.error().code == ErrorCode::NotReady);
}

TEMPLATE_TEST_CASE("an arm that is not active moves for nobody", "[arm][contract]", COLIFT_ARMS) {
  TestType rig;
  REQUIRE(rig.arm->configure());
  JointVector first = palm_ahead_rad();
  for (int i = 0; i < 50; ++i) {
    // some controllers can be watched before they are active; they then say that they take no command
    if (const auto state = rig.arm->wait_cycle()) {
      CHECK_FALSE(state->may_command);
      CHECK(apart(state->q_rad, first) < kStill_rad);
    }
    hal::ImpedanceCommand command;
    command.q_rad = first;
    command.q_rad[1] += 0.001;
    const auto refused = rig.arm->command(command);
    REQUIRE_FALSE(refused);
    CHECK(refused.error().code == ErrorCode::NotReady);
  }
}

TEMPLATE_TEST_CASE("an active arm measures whole states in the order of time", "[arm][contract]",
                   COLIFT_ARMS) {
  TestType rig;
  activate(*rig.arm);
  auto last = next(*rig.arm);
  for (int i = 0; i < 50; ++i) {
    const auto state = next(*rig.arm);
    CHECK(state.measured_at > last.measured_at);
    CHECK(state.may_command);
    CHECK(state.q_rad.allFinite());
    CHECK(state.q_commanded_rad.allFinite());
    CHECK(state.tau_nm.allFinite());
    CHECK(state.tau_external_nm.allFinite());
    CHECK(apart(state.q_rad, palm_ahead_rad()) < kStill_rad);
    last = state;
  }
}

TEMPLATE_TEST_CASE("an arm follows a smooth way and stays at its end", "[arm][contract]", COLIFT_ARMS) {
  TestType rig;
  const JointVector start = activate(*rig.arm);
  const auto way = move(*rig.arm, start);
  JointVector goal = start;
  goal[1] += kMove_rad;
  // lags by less than a tenth of a second, and moves nothing but A2
  for (std::size_t i = 20; i < way.size(); ++i) {
    CHECK(way[i].q_rad[1] >= way[i - 1].q_rad[1] - kStill_rad);
    JointVector others = way[i].q_rad - start;
    others[1] = 0.0;
    CHECK(others.cwiseAbs().maxCoeff() < kStill_rad);
  }
  // without a new command it stays where it was sent last
  for (int i = 0; i < 100; ++i) (void)next(*rig.arm);
  CHECK(apart(next(*rig.arm).q_rad, goal) < kStill_rad);
  CHECK(apart(next(*rig.arm).q_commanded_rad, goal) < 1e-3);
}

TEMPLATE_TEST_CASE("a cycle is answered once", "[arm][contract]", COLIFT_ARMS) {
  TestType rig;
  const JointVector start = activate(*rig.arm);
  hal::ImpedanceCommand command;
  command.q_rad = start;
  REQUIRE(rig.arm->command(command));
  const auto again = rig.arm->command(command);
  REQUIRE_FALSE(again);
  CHECK(again.error().code == ErrorCode::NotReady);
  (void)next(*rig.arm);
  CHECK(rig.arm->command(command));
}

TEMPLATE_TEST_CASE("a command that no arm can follow is refused and moves nothing", "[arm][contract]",
                   COLIFT_ARMS) {
  TestType rig;
  const JointVector start = activate(*rig.arm);
  hal::ImpedanceCommand good;
  good.q_rad = start;
  REQUIRE(rig.arm->command(good));
  std::vector<hal::ImpedanceCommand> bad(5, good);
  bad[0].q_rad[2] = std::numeric_limits<double>::quiet_NaN();
  bad[1].stiffness_nm_rad[0] = std::numeric_limits<double>::infinity();
  bad[2].q_rad[3] = 2.5;  // its limit is 120 deg
  bad[3].stiffness_nm_rad[6] = -1.0;
  bad[4].tau_superposed_nm[1] = std::numeric_limits<double>::quiet_NaN();
  for (const auto& command : bad) {
    (void)next(*rig.arm);
    const auto refused = rig.arm->command(command);
    REQUIRE_FALSE(refused);
    CHECK(refused.error().code == ErrorCode::LimitExceeded);
    CHECK_FALSE(refused.error().detail.empty());
  }
  for (int i = 0; i < 20; ++i) (void)next(*rig.arm);
  CHECK(apart(next(*rig.arm).q_rad, start) < kStill_rad);
}

TEMPLATE_TEST_CASE("a stopped arm refuses to move and stays until it is activated again", "[arm][contract]",
                   COLIFT_ARMS) {
  TestType rig;
  const JointVector start = activate(*rig.arm);
  move(*rig.arm, start, kRamp / 2);  // in the middle of the way, where it is fastest
  for (int i = 0; i < 3; ++i) rig.arm->stop();
  for (int i = 0; i < 60; ++i) {
    if (const auto state = rig.arm->wait_cycle()) CHECK_FALSE(state->may_command);
    const auto refused = rig.arm->command({});
    REQUIRE_FALSE(refused);
    CHECK(refused.error().code == ErrorCode::NotReady);
  }
  REQUIRE(rig.arm->activate());
  const JointVector at_rest = next(*rig.arm).q_rad;
  // rest came within 3 cm of a shoulder's arc
  CHECK(at_rest[1] - start[1] < kMove_rad * 0.5 + 0.03);
  for (int i = 0; i < 60; ++i) (void)next(*rig.arm);
  CHECK(apart(next(*rig.arm).q_rad, at_rest) < kStill_rad);
  move(*rig.arm, next(*rig.arm).q_rad);
  CHECK(next(*rig.arm).q_rad[1] - at_rest[1] == Approx(kMove_rad).margin(2 * kStill_rad));
}

TEMPLATE_TEST_CASE("an arm that is deactivated holds its place", "[arm][contract]", COLIFT_ARMS) {
  TestType rig;
  const JointVector start = activate(*rig.arm);
  move(*rig.arm, start);
  for (int i = 0; i < 60; ++i) (void)next(*rig.arm);
  const JointVector before = next(*rig.arm).q_rad;
  rig.arm->deactivate();
  rig.arm->deactivate();
  rig.arm->stop();
  for (int i = 0; i < 60; ++i) (void)rig.arm->wait_cycle();
  CHECK_FALSE(rig.arm->command({}));
  REQUIRE(rig.arm->activate());
  CHECK(apart(next(*rig.arm).q_rad, before) < kStill_rad);
}

TEMPLATE_TEST_CASE("stop before anything else does no harm", "[arm][contract]", COLIFT_ARMS) {
  TestType rig;
  rig.arm->stop();
  rig.arm->deactivate();
  REQUIRE(rig.arm->configure());
  rig.arm->stop();
  REQUIRE(rig.arm->activate());
  CHECK(next(*rig.arm).may_command);
}

TEMPLATE_TEST_CASE("the same commands give the same states, bit for bit", "[arm][contract]", COLIFT_ARMS) {
  TestType one, other;
  const auto first = move(*one.arm, activate(*one.arm));
  const auto second = move(*other.arm, activate(*other.arm));
  for (std::size_t i = 0; i < first.size(); ++i) {
    CHECK(first[i].measured_at == second[i].measured_at);
    CHECK(first[i].q_rad == second[i].q_rad);
    CHECK(first[i].tau_nm == second[i].tau_nm);
    CHECK(first[i].tau_external_nm == second[i].tau_external_nm);
  }
}

TEMPLATE_TEST_CASE("an arm's health counts its cycles", "[arm][contract]", COLIFT_ARMS) {
  TestType rig;
  CHECK(rig.arm->health().accepted == 0);
  activate(*rig.arm);
  for (int i = 0; i < 9; ++i) (void)next(*rig.arm);
  CHECK(rig.arm->health().accepted == 10);
  CHECK(rig.arm->health().rejected == 0);
  CHECK(rig.arm->health().state == hal::DeviceHealth::State::Streaming);
}

}  // namespace colift
