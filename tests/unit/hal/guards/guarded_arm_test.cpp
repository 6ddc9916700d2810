// What the last gate makes of commands: passed unchanged, refused with numbers, braked within limits.
#include "guarded_arm_rig.hpp"
#include "sim_hal/mock/mock_arm.hpp"

using namespace guards;
using Catch::Matchers::Contains;

TEST_CASE("a good command passes unchanged", "[guard]") {
  Rig rig;
  REQUIRE(rig.cycle());
  REQUIRE(rig.send(rig.state.q_rad));
  JointVector q = rig.state.q_rad;
  q[3] += 1e-4;
  REQUIRE(rig.cycle());
  REQUIRE(rig.send(q));
  CHECK(rig.wire->q == q);
  rig.check_judge();
}

TEST_CASE("a refusal names the joint and the numbers", "[guard]") {
  Rig rig;
  REQUIRE(rig.cycle());
  REQUIRE(rig.send(rig.state.q_rad));
  REQUIRE(rig.cycle());
  JointVector q = rig.state.q_rad;
  q[2] += 0.1;
  const auto answer = rig.send(q);
  REQUIRE_FALSE(answer);
  CHECK(answer.error().code == ErrorCode::LimitExceeded);
  CHECK_THAT(answer.error().detail, Contains("A3") && Contains("20.000 rad/s"));
  CHECK_THAT(rig.arm->health().last_error, Contains("A3"));
  CHECK(rig.wire->q == rig.state.q_rad);
  rig.check_judge();
}

TEST_CASE("a bad command in full motion brings the arm to rest within its limits", "[guard]") {
  for (const double spoiled : {kNan, std::numeric_limits<double>::infinity(), 3.0, -50.0}) {
    Rig rig;
    rig.run_up_to(1.0);
    JointVector q = rig.state.q_rad;
    q[5] = spoiled;
    int cycles = 0;
    for (; rig.wire->dq.cwiseAbs().maxCoeff() > 0.0 && cycles < 100; ++cycles) {
      REQUIRE(rig.cycle());
      CHECK_FALSE(rig.send(q));
      rig.state.q_rad = rig.wire->q;
    }
    CHECK(cycles == 14);  // 1 rad/s at 15 rad/s^2 in cycles of 5 ms
    rig.check_judge();
  }
}

TEST_CASE("a caller who stops answering leaves an arm that comes to rest", "[guard]") {
  Rig rig;
  rig.run_up_to(1.0);
  const std::uint64_t before = rig.wire->commands;
  for (int i = 0; i < 20; ++i) REQUIRE(rig.cycle());
  CHECK(rig.wire->commands == before + 19);  // all but the newest cycle, which may still be answered
  CHECK(rig.wire->dq.norm() == 0.0);
  rig.check_judge();
}

TEST_CASE("the first command is the measured pose to the last bit, whatever was given for it", "[guard]") {
  Rig rig;
  REQUIRE(rig.cycle());
  JointVector q = rig.state.q_rad;
  q[0] += 5e-5;
  CHECK(rig.send(q));
  CHECK(rig.wire->q == rig.state.q_rad);

  Rig other;
  REQUIRE(other.cycle());
  q[4] = kNan;
  CHECK(code(other.send(q)) == ErrorCode::LimitExceeded);
  CHECK(other.wire->q == other.state.q_rad);
  other.check_judge();
}

TEST_CASE("an arm that was deactivated gets no command until it is activated", "[guard]") {
  Rig rig;
  rig.run_up_to(0.2);
  const std::uint64_t before = rig.wire->commands;
  rig.arm->deactivate();
  REQUIRE(rig.cycle());
  CHECK(code(rig.send(rig.state.q_rad)) == ErrorCode::NotReady);
  REQUIRE(rig.cycle());
  CHECK(rig.wire->commands == before);
  rig.check_judge();
}

TEST_CASE("a torque that creeps up ends at what the joint bears", "[guard]") {
  Rig rig;
  ImpedanceCommand c;
  c.q_rad = rig.state.q_rad;
  REQUIRE(rig.cycle());
  REQUIRE(rig.arm->command(c));
  bool refused = false;
  for (int i = 0; i < 200 && !refused; ++i) {
    c.tau_superposed_nm.array() += 0.9;
    REQUIRE(rig.cycle());
    refused = !rig.arm->command(c);
  }
  CHECK(refused);
  CHECK(rig.wire->tau[6] <= 38.0);
  CHECK(rig.wire->tau[6] > 36.0);
  rig.check_judge();
}

TEST_CASE("time of lost cycles is not caught up in one step", "[guard]") {
  Rig rig;
  rig.run_up_to(0.5);
  rig.wire->fail_wait = ErrorCode::Timeout;
  CHECK(code(rig.cycle()) == ErrorCode::Timeout);
  CHECK(rig.cycle(0.0).has_value());  // two periods after the last state
  const JointVector here = rig.wire->q;
  JointVector late = here;
  late[0] += 2 * 0.5 * kPeriod_s;  // where it would be had nothing been lost
  CHECK_FALSE(rig.send(late));
  rig.state.q_rad = rig.wire->q;
  rig.check_judge();
}

TEST_CASE("one lost cycle does not stop a caller who goes on from where he was", "[guard]") {
  Rig rig;
  rig.run_up_to(0.5);
  rig.wire->fail_wait = ErrorCode::Timeout;
  CHECK_FALSE(rig.cycle());
  REQUIRE(rig.cycle(0.0));
  JointVector q = rig.wire->q;
  q[0] += 0.5 * kPeriod_s;
  CHECK(rig.send(q));
  rig.check_judge();
}

TEST_CASE("no command comes nearer to a joint's end than the margin, however slowly", "[guard]") {
  Rig rig;
  rig.state.q_rad[6] = rig.limits.upper[6] - 0.02;
  REQUIRE(rig.cycle());
  REQUIRE(rig.send(rig.state.q_rad));
  JointVector q = rig.state.q_rad;
  bool refused = false;
  for (int i = 0; i < 1000 && !refused; ++i) {
    q[6] += 5e-5;
    REQUIRE(rig.cycle());
    refused = !rig.send(q);
    rig.state.q_rad = rig.wire->q;
  }
  CHECK(refused);
  CHECK(rig.wire->q[6] <= rig.limits.upper[6]);
  CHECK(rig.wire->q[6] > rig.limits.upper[6] - 0.001);
  rig.check_judge();
}

TEST_CASE("an arm found beyond the margin may come back, not go further", "[guard]") {
  Rig rig;
  rig.state.q_rad[1] = rig.limits.lower[1] - 0.01;
  REQUIRE(rig.cycle());
  REQUIRE(rig.send(rig.state.q_rad));
  JointVector q = rig.state.q_rad;
  q[1] -= 1e-5;
  REQUIRE(rig.cycle());
  CHECK_FALSE(rig.send(q));
  q[1] = rig.state.q_rad[1] + 1e-5;
  REQUIRE(rig.cycle());
  CHECK(rig.send(q));
  rig.check_judge();
}

TEST_CASE("stiffness, damping and superposed torque have limits, and the torque a slope", "[guard]") {
  Rig rig;
  REQUIRE(rig.cycle());
  REQUIRE(rig.send(rig.state.q_rad));
  const auto refused = [&](auto change) {
    ImpedanceCommand c;
    c.q_rad = rig.state.q_rad;
    change(c);
    REQUIRE(rig.cycle());
    const auto answer = rig.arm->command(c);
    return answer ? ErrorCode::NotFound : answer.error().code;
  };
  CHECK(refused([](ImpedanceCommand& c) { c.stiffness_nm_rad[0] = 2001; }) == ErrorCode::LimitExceeded);
  CHECK(refused([](ImpedanceCommand& c) { c.stiffness_nm_rad[1] = -1; }) == ErrorCode::LimitExceeded);
  CHECK(refused([](ImpedanceCommand& c) { c.damping_ratio[2] = 1.1; }) == ErrorCode::LimitExceeded);
  CHECK(refused([](ImpedanceCommand& c) { c.damping_ratio[3] = kNan; }) == ErrorCode::LimitExceeded);
  CHECK(refused([](ImpedanceCommand& c) { c.tau_superposed_nm[4] = 61; }) == ErrorCode::LimitExceeded);
  CHECK(refused([](ImpedanceCommand& c) { c.tau_superposed_nm[5] = 1.1; }) == ErrorCode::LimitExceeded);
  CHECK(refused([](ImpedanceCommand& c) { c.tau_superposed_nm[5] = 1.0; }) == ErrorCode::NotFound);
  CHECK(rig.wire->tau[5] == 1.0);
  rig.check_judge();
}

TEST_CASE("a guarded mock arm follows a good caller and survives its faults", "[guard]") {
  using colift::sim_hal::MockArm;
  ManualClock clock;
  auto owned = std::make_unique<MockArm>(colift::sim_hal::ArmScript{}, clock);
  MockArm& mock = *owned;
  GuardedArm arm(std::move(owned), built_in_robot(), GuardConfig{});
  REQUIRE(arm.configure());
  REQUIRE(arm.activate());
  mock.inject(MockArm::Fault::Freeze, 100, 3);
  mock.inject(MockArm::Fault::Drop, 200, 2);
  mock.inject(MockArm::Fault::Jump, 300, 2);
  mock.inject(MockArm::Fault::Nan, 400, 2);

  JointVector q = JointVector::Zero();
  int refused = 0, lost = 0;
  for (int i = 0; i < 600; ++i) {
    const auto state = arm.wait_cycle();
    if (!state) {
      ++lost;
      continue;
    }
    ImpedanceCommand c;
    c.q_rad = q;
    if (!arm.command(c)) {
      ++refused;
      q = mock.last_command()->q_rad;  // a caller who takes up the command that stands
    } else if (i < 500) {
      q[0] += 2e-5;
    }
  }
  CHECK(lost >= 6);
  CHECK(refused < 20);
  CHECK(mock.q_rad()[0] == Approx(q[0]).margin(1e-6));
  CHECK(q[0] > 0.005);
}
