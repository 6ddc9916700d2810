#pragma once

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <memory>
#include <vector>

#include "colift/contract/catch.hpp"
#include "hal/arm.hpp"

namespace colift::contract {

/// An arm under test, ready to be configured, at rest, with nothing in its reach.
struct ArmUnderTest {
  std::shared_ptr<void> rig;  ///< Owns the arm and what it needs to live: clock, far end, world.
  hal::Arm* arm = nullptr;
};

/// Makes one; called anew for each fact, and twice where two runs are compared.
using MakeArm = std::function<ArmUnderTest()>;

/// What the suite has to know about an arm. Angles in rad.
struct ArmTraits {
  hal::JointVector start_rad = hal::JointVector::Zero();  ///< Where it is when it was made.
  double tolerance_rad = 0.003;  ///< It yields so much under its own weight, in any joint.
  int moved_joint = 1;           ///< Joint that is moved, counted from 0.
  double move_rad = 0.10;        ///< How far: without contact and within all limits.
  int move_cycles = 200;         ///< In how many cycles, along a polynomial that starts and ends at rest.
  double stop_rad = 0.03;        ///< A stop from the middle of that path comes to rest within this.
  int limited_joint = 3;         ///< Joint with a limit below beyond_rad.
  double beyond_rad = 2.5;       ///< LWR 4+: A4 is limited to 120 deg.
  bool repeatable = true;        ///< The same calls on a new arm give the same states, bit for bit.
};

namespace detail {

inline hal::ArmState next_state(hal::Arm& arm) {
  const auto state = arm.wait_cycle();
  REQUIRE(state);
  return *state;
}

inline void wait_cycles(hal::Arm& arm, int cycles) {
  for (int i = 0; i < cycles; ++i) (void)next_state(arm);
}

/// Commands that lead one joint smoothly from `from` along the first `cycles` of the move; returns every
/// measured state.
inline std::vector<hal::ArmState> move(hal::Arm& arm, const ArmTraits& traits, const hal::JointVector& from,
                                       int cycles) {
  std::vector<hal::ArmState> states;
  for (int i = 0; i < cycles; ++i) {
    states.push_back(next_state(arm));
    const double s = static_cast<double>(i) / traits.move_cycles;
    hal::ImpedanceCommand command;
    command.q_rad = from;
    command.q_rad[traits.moved_joint] += traits.move_rad * s * s * s * (10.0 + s * (6.0 * s - 15.0));
    REQUIRE(arm.command(command));
  }
  return states;
}

inline std::vector<hal::ArmState> move(hal::Arm& arm, const ArmTraits& traits, const hal::JointVector& from) {
  return move(arm, traits, from, traits.move_cycles);
}

inline hal::JointVector activate(hal::Arm& arm) {
  REQUIRE(arm.configure());
  REQUIRE(arm.activate());
  return next_state(arm).q_rad;
}

inline double max_difference(const hal::JointVector& a, const hal::JointVector& b) {
  return (a - b).cwiseAbs().maxCoeff();
}

inline std::vector<hal::ImpedanceCommand> impossible_commands(const ArmTraits& traits,
                                                              const hal::ImpedanceCommand& good) {
  std::vector<hal::ImpedanceCommand> bad(5, good);
  bad[0].q_rad[2] = std::numeric_limits<double>::quiet_NaN();
  bad[1].stiffness_nm_rad[0] = std::numeric_limits<double>::infinity();
  bad[2].q_rad[traits.limited_joint] = traits.beyond_rad;
  bad[3].stiffness_nm_rad[6] = -1.0;
  bad[4].tau_superposed_nm[1] = std::numeric_limits<double>::quiet_NaN();
  return bad;
}

}  // namespace detail

/// What every hal::Arm promises (hal/arm.hpp, hal/device.hpp), one section for each fact. To be called from
/// a test case of its own:
///
///   TEST_CASE("my arm keeps the contract of an arm") {
///     contract::check_arm([] {
///       auto rig = std::make_shared<MyRig>();  // whatever the arm needs, and the arm
///       return contract::ArmUnderTest{rig, &rig->arm};
///     });
///   }
///
/// The arm moves by ArmTraits::move_rad; some thousand cycles in all.
inline void check_arm(const MakeArm& make, const ArmTraits& traits = {}) {
  using hal::ErrorCode;
  const double tolerance_rad = traits.tolerance_rad;

  SECTION("it says what it can, and takes as much") {
    const ArmUnderTest test = make();
    const hal::ArmAbilities can = test.arm->abilities();
    CHECK(can.min_period_s > 0.0);
    CHECK(can.min_period_s <= can.max_period_s);
    CHECK(can.max_superposed_nm.allFinite());
    CHECK(can.max_superposed_nm.minCoeff() >= 0.0);
    REQUIRE((can.joint_impedance || can.position || can.cartesian_impedance));
    if (can.joint_impedance) {
      const hal::JointVector from = detail::activate(*test.arm);
      hal::ImpedanceCommand command;
      command.q_rad = from;
      command.stiffness_nm_rad.setConstant(std::min(can.max_stiffness_nm_rad, 1000.0));
      REQUIRE(test.arm->command(command));
      // what the arm cannot take is never asked of it: beyond its own figure it refuses
      (void)detail::next_state(*test.arm);
      command.stiffness_nm_rad.setConstant(can.max_stiffness_nm_rad * 1.01 + 1.0);
      CHECK_FALSE(test.arm->command(command));
    }
  }
  SECTION("an arm reports nothing and does nothing before it is configured") {
    const ArmUnderTest test = make();
    const auto state = test.arm->wait_cycle();
    REQUIRE_FALSE(state);
    CHECK(state.error().code == ErrorCode::NotReady);
    CHECK_FALSE(state.error().detail.empty());
    const auto command = test.arm->command({});
    REQUIRE_FALSE(command);
    CHECK(command.error().code == ErrorCode::NotReady);
    const auto active = test.arm->activate();
    REQUIRE_FALSE(active);
    CHECK(active.error().code == ErrorCode::NotReady);
  }

  SECTION("an arm that is not active takes no command") {
    const ArmUnderTest test = make();
    REQUIRE(test.arm->configure());
    for (int i = 0; i < 50; ++i) {
      // some controllers can be read before they are active; they then say that they take no command
      if (const auto state = test.arm->wait_cycle()) {
        CHECK_FALSE(state->may_command);
        CHECK(detail::max_difference(state->q_rad, traits.start_rad) < tolerance_rad);
      }
      hal::ImpedanceCommand command;
      command.q_rad = traits.start_rad;
      command.q_rad[traits.moved_joint] += 0.001;
      const auto refused = test.arm->command(command);
      REQUIRE_FALSE(refused);
      CHECK(refused.error().code == ErrorCode::NotReady);
    }
  }

  SECTION("an active arm measures whole states in the order of time") {
    const ArmUnderTest test = make();
    detail::activate(*test.arm);
    auto last = detail::next_state(*test.arm);
    for (int i = 0; i < 50; ++i) {
      const auto state = detail::next_state(*test.arm);
      CHECK(state.measured_at > last.measured_at);
      CHECK(state.may_command);
      CHECK(state.q_rad.allFinite());
      CHECK(state.q_commanded_rad.allFinite());
      CHECK(state.tau_nm.allFinite());
      CHECK(state.tau_external_nm.allFinite());
      CHECK(detail::max_difference(state.q_rad, traits.start_rad) < tolerance_rad);
      last = state;
    }
  }

  SECTION("an arm follows a smooth path and stays at its end") {
    const ArmUnderTest test = make();
    const hal::JointVector start = detail::activate(*test.arm);
    const auto path = detail::move(*test.arm, traits, start);
    const int joint = traits.moved_joint;
    const double forward = traits.move_rad < 0.0 ? -1.0 : 1.0;
    hal::JointVector goal = start;
    goal[joint] += traits.move_rad;
    // lags by less than a tenth of a second, and moves nothing but this joint
    for (std::size_t i = 20; i < path.size(); ++i) {
      CHECK(forward * (path[i].q_rad[joint] - path[i - 1].q_rad[joint]) >= -tolerance_rad);
      hal::JointVector others = path[i].q_rad - start;
      others[joint] = 0.0;
      CHECK(others.cwiseAbs().maxCoeff() < tolerance_rad);
    }
    // without a new command it stays where it was sent last
    detail::wait_cycles(*test.arm, 100);
    CHECK(detail::max_difference(detail::next_state(*test.arm).q_rad, goal) < tolerance_rad);
    CHECK(detail::max_difference(detail::next_state(*test.arm).q_commanded_rad, goal) < 1e-3);
  }

  SECTION("a cycle is answered once") {
    const ArmUnderTest test = make();
    hal::ImpedanceCommand command;
    command.q_rad = detail::activate(*test.arm);
    REQUIRE(test.arm->command(command));
    const auto again = test.arm->command(command);
    REQUIRE_FALSE(again);
    CHECK(again.error().code == ErrorCode::NotReady);
    (void)detail::next_state(*test.arm);
    CHECK(test.arm->command(command));
  }

  SECTION("a command that no arm can follow is refused and moves nothing") {
    const ArmUnderTest test = make();
    const hal::JointVector start = detail::activate(*test.arm);
    hal::ImpedanceCommand good;
    good.q_rad = start;
    REQUIRE(test.arm->command(good));
    for (const auto& command : detail::impossible_commands(traits, good)) {
      (void)detail::next_state(*test.arm);
      const auto refused = test.arm->command(command);
      REQUIRE_FALSE(refused);
      CHECK(refused.error().code == ErrorCode::LimitExceeded);
      CHECK_FALSE(refused.error().detail.empty());
    }
    detail::wait_cycles(*test.arm, 20);
    CHECK(detail::max_difference(detail::next_state(*test.arm).q_rad, start) < tolerance_rad);
  }

  SECTION("a stopped arm refuses to move and stays at rest until it is activated again") {
    const ArmUnderTest test = make();
    const int joint = traits.moved_joint;
    const hal::JointVector start = detail::activate(*test.arm);
    detail::move(*test.arm, traits, start, traits.move_cycles / 2);  // in the middle it is fastest
    for (int i = 0; i < 3; ++i) test.arm->stop();
    for (int i = 0; i < 60; ++i) {
      if (const auto state = test.arm->wait_cycle()) CHECK_FALSE(state->may_command);
      const auto refused = test.arm->command({});
      REQUIRE_FALSE(refused);
      CHECK(refused.error().code == ErrorCode::NotReady);
    }
    REQUIRE(test.arm->activate());
    const hal::JointVector at_rest = detail::next_state(*test.arm).q_rad;
    CHECK(std::abs(at_rest[joint] - start[joint]) < std::abs(traits.move_rad) * 0.5 + traits.stop_rad);
    detail::wait_cycles(*test.arm, 60);
    CHECK(detail::max_difference(detail::next_state(*test.arm).q_rad, at_rest) < tolerance_rad);
    detail::move(*test.arm, traits, detail::next_state(*test.arm).q_rad);
    const double moved_rad = detail::next_state(*test.arm).q_rad[joint] - at_rest[joint];
    CHECK(std::abs(moved_rad - traits.move_rad) < 2 * tolerance_rad);
  }

  SECTION("an arm that is deactivated holds its position") {
    const ArmUnderTest test = make();
    detail::move(*test.arm, traits, detail::activate(*test.arm));
    detail::wait_cycles(*test.arm, 60);
    const hal::JointVector before = detail::next_state(*test.arm).q_rad;
    test.arm->deactivate();
    test.arm->deactivate();
    test.arm->stop();
    for (int i = 0; i < 60; ++i) (void)test.arm->wait_cycle();
    CHECK_FALSE(test.arm->command({}));
    REQUIRE(test.arm->activate());
    CHECK(detail::max_difference(detail::next_state(*test.arm).q_rad, before) < tolerance_rad);
  }

  SECTION("stop before anything else does no harm") {
    const ArmUnderTest test = make();
    test.arm->stop();
    test.arm->deactivate();
    REQUIRE(test.arm->configure());
    test.arm->stop();
    REQUIRE(test.arm->activate());
    CHECK(detail::next_state(*test.arm).may_command);
  }

  SECTION("an arm's health counts its cycles") {
    const ArmUnderTest test = make();
    CHECK(test.arm->health().accepted == 0);
    detail::activate(*test.arm);
    detail::wait_cycles(*test.arm, 9);
    CHECK(test.arm->health().accepted == 10);
    CHECK(test.arm->health().rejected == 0);
    CHECK(test.arm->health().state == hal::DeviceHealth::State::Streaming);
  }

  if (!traits.repeatable) return;
  SECTION("the same commands give the same states, bit for bit") {
    const ArmUnderTest one = make(), other = make();
    const auto first = detail::move(*one.arm, traits, detail::activate(*one.arm));
    const auto second = detail::move(*other.arm, traits, detail::activate(*other.arm));
    for (std::size_t i = 0; i < first.size(); ++i) {
      CHECK(first[i].measured_at == second[i].measured_at);
      CHECK(first[i].q_rad == second[i].q_rad);
      CHECK(first[i].tau_nm == second[i].tau_nm);
      CHECK(first[i].tau_external_nm == second[i].tau_external_nm);
    }
  }
}

}  // namespace colift::contract
