#include <catch2/catch.hpp>
#include <cmath>

#include "lift_rig.hpp"
#include "sim_hal/mujoco/devices/sim_devices.hpp"

namespace colift::sim_hal {
namespace {

using hal::ErrorCode;
using hal::JointVector;

constexpr auto kMs = std::chrono::milliseconds(1);

std::unique_ptr<SimWorld> empty_world(std::vector<DeviceFaultEvent> faults = {}) {
  Scenario s = table_scenario();
  s.object.xyz = {2.5, 0.0, 0.0};
  s.partner.kind = "none";
  s.faults = std::move(faults);
  auto world = SimWorld::make(s, hal::built_in_robot(), 1, {});
  REQUIRE(world);
  return std::move(*world);
}

hal::ImpedanceCommand hold_at(const JointVector& q_rad) {
  hal::ImpedanceCommand c;
  c.q_rad = q_rad;
  return c;
}

TEST_CASE("the arm stands against gravity without a client") {
  const auto world = empty_world();
  const auto start = hal::hand_pose(world->model(), world->arm_state().q_rad).translation().eval();
  world->advance(2000 * kMs);
  const hal::ArmState state = world->arm_state();
  CHECK((hal::hand_pose(world->model(), state.q_rad).translation() - start).norm() < 1e-4);
  CHECK(state.tau_external_nm.norm() == 0.0);
  // the elbow carries forearm and hand: about 4.5 kg whose middle is some 0.35 m in front of it
  CHECK(std::abs(state.tau_nm[3]) == Approx(15.0).margin(5.0));
  CHECK_FALSE(world->truth().robot_hit_something);
}

TEST_CASE("the arm follows a slow sine in every joint") {
  const auto world = empty_world();
  const JointVector start = world->arm_state().q_rad;
  hal::ImpedanceCommand c = hold_at(start);
  c.stiffness_nm_rad.setConstant(1500.0);
  double worst = 0.0;
  for (int i = 0; i < 800; ++i) {
    c.q_rad = start.array() + 0.2 * std::sin(2.0 * M_PI * 0.25 * 0.005 * (i + 1));
    world->command_arm(c);
    world->advance(5 * kMs);
    worst = std::max(worst, (world->arm_state().q_rad - c.q_rad).cwiseAbs().maxCoeff());
  }
  CHECK(worst < 0.025);
}

TEST_CASE("a superposed torque moves a joint by torque over stiffness") {
  const auto world = empty_world();
  hal::ImpedanceCommand c = hold_at(world->arm_state().q_rad);
  c.stiffness_nm_rad.setConstant(500.0);
  for (int i = 0; i < hal::kArmJoints; ++i) {
    c.tau_superposed_nm.setZero();
    c.tau_superposed_nm[i] = 5.0;
    world->command_arm(c);
    world->advance(3000 * kMs);
    const JointVector moved = world->arm_state().q_rad - c.q_rad;
    CHECK(moved[i] == Approx(0.01).margin(1e-4));
    CHECK((moved - moved[i] * JointVector::Unit(i)).norm() < 1e-4);
  }
}

TEST_CASE("no joint gives more than its effort") {
  const auto world = empty_world();
  const JointVector effort = world->model().effort_nm();
  hal::ImpedanceCommand c = hold_at(world->arm_state().q_rad + JointVector::Constant(0.5));
  c.stiffness_nm_rad.setConstant(2000.0);
  world->command_arm(c);
  bool reached = false;
  for (int i = 0; i < 300; ++i) {
    world->advance(kMs);
    const JointVector tau = world->arm_state().tau_nm;
    REQUIRE(((effort - tau.cwiseAbs()).array() >= 0.0).all());
    reached = reached || (tau.cwiseAbs() - effort).cwiseAbs().minCoeff() == 0.0;
  }
  CHECK(reached);
}

TEST_CASE("a hold keeps the torque, so a loaded arm stays where it is") {
  const auto world = empty_world();
  hal::ImpedanceCommand c = hold_at(world->arm_state().q_rad);
  c.tau_superposed_nm[1] = 15.0;
  world->command_arm(c);
  world->advance(1500 * kMs);
  const JointVector before = world->arm_state().q_rad;
  world->hold_arm();
  world->advance(1000 * kMs);
  CHECK((world->arm_state().q_rad - before).norm() < 1e-5);
}

TEST_CASE("the set point goes in a straight line through one cycle") {
  const auto world = empty_world();
  const JointVector start = world->arm_state().q_rad;
  world->command_arm(hold_at(start + JointVector::Constant(0.005)));
  for (int ms = 1; ms <= 7; ++ms) {
    world->advance(kMs);
    CHECK(world->arm_state().q_commanded_rad[2] - start[2] == Approx(0.001 * std::min(ms, 5)).margin(1e-12));
  }
}

TEST_CASE("the device refuses what does not fit its state") {
  const auto world = empty_world();
  const auto arm = make_sim_arm(*world);
  CHECK(arm->activate().error().code == ErrorCode::NotReady);
  CHECK(arm->wait_cycle().error().code == ErrorCode::NotReady);
  REQUIRE(arm->configure());
  CHECK_FALSE(arm->wait_cycle()->may_command);
  REQUIRE(arm->activate());
  const auto state = arm->wait_cycle();
  REQUIRE(state);
  CHECK(state->may_command);
  CHECK(state->measured_at == world->clock().now());
  CHECK(arm->command(hold_at(state->q_rad)));
  CHECK(arm->command(hold_at(state->q_rad)).error().code == ErrorCode::NotReady);  // the cycle is answered
  arm->stop();
  arm->stop();
  REQUIRE(arm->wait_cycle());
  CHECK(arm->command(hold_at(state->q_rad)).error().code == ErrorCode::NotReady);
  CHECK(arm->activate());
  REQUIRE(arm->wait_cycle());
  CHECK(arm->command(hold_at(state->q_rad)));
}

TEST_CASE("a client begins where the arm is, beside where soft springs have left its set point") {
  const auto world =
      empty_world({{.at_s = 0.0, .device = "arm", .action = "push", .for_s = 60.0, .value = 30.0}});
  hal::ImpedanceCommand soft = hold_at(world->arm_state().q_rad);
  soft.stiffness_nm_rad.setConstant(150.0);
  world->command_arm(soft);
  world->advance(3000 * kMs);
  world->hold_arm();
  const auto arm = make_sim_arm(*world);
  REQUIRE(arm->configure());
  REQUIRE(arm->activate());
  auto state = arm->wait_cycle();
  REQUIRE(state);
  REQUIRE((state->q_rad - state->q_commanded_rad).cwiseAbs().maxCoeff() > 0.04);
  CHECK(arm->command(hold_at(state->q_commanded_rad)).error().code == ErrorCode::LimitExceeded);
  CHECK(arm->command(hold_at(state->q_rad)));
  state = arm->wait_cycle();
  CHECK(arm->command(hold_at(state->q_commanded_rad)));
}

TEST_CASE("a command with NaN, beyond a limit or with a leap changes nothing") {
  const auto world = empty_world();
  const auto arm = make_sim_arm(*world);
  REQUIRE(arm->configure());
  REQUIRE(arm->activate());
  const JointVector start = arm->wait_cycle()->q_rad;
  hal::ImpedanceCommand bad = hold_at(start);
  SECTION("NaN") {
    bad.tau_superposed_nm[4] = std::nan("");
  }
  SECTION("leap") {
    bad.q_rad[2] += 0.05;
  }
  SECTION("limit") {
    bad.q_rad[3] = 2.2;
  }
  SECTION("stiffness") {
    bad.stiffness_nm_rad[0] = 2500.0;
  }
  CHECK(arm->command(bad).error().code == ErrorCode::LimitExceeded);
  CHECK(arm->command(hold_at(start)));
}

TEST_CASE("a scenario's faults of the arm show as the interface says") {
  const auto world = empty_world({{0.1, "arm", "drop", 0.05},
                                  {0.2, "arm", "freeze", 0.05},
                                  {0.3, "arm", "corrupt", 0.05},
                                  {0.4, "arm", "late", 0.1},
                                  {0.6, "arm", "unplug", 0.1}});
  const auto arm = make_sim_arm(*world);
  REQUIRE(arm->configure());
  REQUIRE(arm->activate());
  int timeouts = 0, frozen = 0, corrupt = 0, lost = 0;
  hal::Timestamp last{0}, longest{0};
  while (world->clock().now() < std::chrono::milliseconds(700)) {
    const auto state = arm->wait_cycle();
    if (!state) {
      timeouts += state.error().code == ErrorCode::Timeout;
      lost += state.error().code == ErrorCode::LinkLost;
      continue;
    }
    frozen += state->measured_at == last;
    corrupt += !state->q_rad.allFinite();
    longest = std::max(longest, state->measured_at - last);
    last = state->measured_at;
  }
  CHECK(timeouts == 10);
  CHECK(frozen == 10);
  CHECK(corrupt == 10);
  CHECK(lost > 15);
  CHECK(longest == std::chrono::milliseconds(55));
  CHECK(arm->wait_cycle().error().code == ErrorCode::LinkLost);  // until it is configured anew
  CHECK(arm->health().state == hal::DeviceHealth::State::Lost);
  CHECK(arm->configure());
  CHECK(arm->activate());
  CHECK(arm->wait_cycle());
}

}  // namespace
}  // namespace colift::sim_hal
