// What the last gate makes of measured states: garbage, doubles, gaps, a clock set back, a stuck joint.
#include "guarded_arm_rig.hpp"

using namespace guards;
using Catch::Matchers::Contains;

TEST_CASE("a measured state that cannot be is not passed on, and brakes the arm", "[guard]") {
  const auto spoil = GENERATE(0, 1, 2, 3, 4, 5);
  Rig rig;
  rig.run_up_to(0.5);
  const ArmState good = rig.state;
  switch (spoil) {
    case 0:
      rig.state.q_rad[4] = kNan;
      break;
    case 1:
      rig.state.tau_external_nm[1] = std::numeric_limits<double>::infinity();
      break;
    case 2:
      rig.state.q_rad[1] += 0.3;
      break;
    case 3:
      rig.state.q_rad[1] = 9.0;
      break;
    case 4:
      rig.state.q_commanded_rad[2] = kNan;
      break;
    default:
      rig.state.tau_nm[6] = kNan;
      break;
  }
  const auto state = rig.cycle();
  REQUIRE_FALSE(state);
  CHECK(state.error().code == ErrorCode::BadReply);
  CHECK(rig.wire->dq[0] == Approx(0.5 - 15.0 * kPeriod_s));
  CHECK_FALSE(rig.send(good.q_rad));  // there is nothing to answer
  rig.check_judge();
}

TEST_CASE("a state that came twice or late is answered by nobody", "[guard]") {
  Rig rig;
  rig.run_up_to(0.2);
  const std::uint64_t before = rig.wire->commands;
  for (const double step_s : {0.0, -kPeriod_s, 0.0001}) {
    rig.wire->cycle_counts = false;
    const auto state = rig.cycle(step_s);
    REQUIRE_FALSE(state);
    CHECK(state.error().code == ErrorCode::BadReply);
    CHECK_FALSE(rig.send(rig.state.q_rad));
    rig.state.measured_at -= Timestamp(static_cast<std::int64_t>(step_s * 1e9));
  }
  CHECK(rig.wire->commands == before);
  rig.check_judge();
}

TEST_CASE("after a gap the arm starts from where it is, never for its old target", "[guard]") {
  Rig rig;
  rig.run_up_to(1.0);
  const JointVector old = rig.wire->q;
  rig.state.q_rad[0] += 0.04;  // it ran on, and fell to rest
  rig.wire->must_restart = true;
  REQUIRE(rig.cycle(0.2));
  const auto answer = rig.send(old);
  REQUIRE_FALSE(answer);
  CHECK_THAT(answer.error().detail, Contains("measured pose"));
  CHECK(rig.wire->q == rig.state.q_rad);
  // and from there in steps within the limits only
  REQUIRE(rig.cycle());
  CHECK_FALSE(rig.send(old));
  CHECK(rig.wire->q == rig.state.q_rad);
  REQUIRE(rig.cycle());
  CHECK(rig.send(rig.state.q_rad));
  rig.check_judge();
}

TEST_CASE("the same holds after a stop, a loss of command mode and a fault of the arm", "[guard]") {
  const auto how = GENERATE(0, 1, 2, 3);
  Rig rig;
  rig.run_up_to(1.0);
  const JointVector old = rig.wire->q;
  switch (how) {
    case 0:
      rig.arm->stop();
      REQUIRE(rig.cycle());
      CHECK(code(rig.send(old)) == ErrorCode::NotReady);
      REQUIRE(rig.arm->activate());
      break;
    case 1:
      rig.state.may_command = false;
      rig.wire->must_restart = true;
      REQUIRE(rig.cycle());
      CHECK(code(rig.send(old)) == ErrorCode::NotReady);
      rig.state.may_command = true;
      break;
    case 2:
      REQUIRE(rig.cycle());
      rig.wire->fail_command = true;
      rig.state.q_rad[0] += 1.0 * kPeriod_s;
      CHECK(code(rig.send(rig.state.q_rad)) == ErrorCode::DeviceFault);
      break;
    default:
      rig.wire->fail_wait = ErrorCode::LinkLost;
      rig.wire->restart_from_here = true;
      CHECK(code(rig.cycle()) == ErrorCode::LinkLost);
      break;
  }
  rig.state.q_rad[0] += 0.02;
  REQUIRE(rig.cycle());
  CHECK_FALSE(rig.send(old));
  CHECK(rig.wire->q == rig.state.q_rad);
  CHECK(rig.wire->restarts == 2);
  rig.check_judge();
}

TEST_CASE("an arm whose clock was set back is taken up anew, from where it is", "[guard]") {
  Rig rig;
  rig.run_up_to(0.5);
  rig.state.measured_at = Timestamp(1'000'000);
  rig.wire->cycle_counts = false;
  int refused = 0;
  while (!rig.cycle() && refused < 100) {
    ++refused;
    if (refused == 10) rig.wire->restart_from_here = rig.wire->cycle_counts = true;
  }
  CHECK(refused >= 10);
  CHECK(refused < 13);  // 50 ms of nothing but older states
  const auto answer = rig.send(rig.state.q_rad);
  INFO((answer ? "" : answer.error().text()));
  REQUIRE(answer);
  CHECK(rig.wire->restarts == 2);
  rig.check_judge();
}

TEST_CASE("a measured position that stands still to the last bit while the command moves is a fault",
          "[guard]") {
  Rig rig;
  rig.run_up_to(0.5);
  JointVector q = rig.wire->q;
  Result<ArmState> state;
  int cycles = 0;
  for (; cycles < 100; ++cycles) {
    state = rig.cycle();
    if (!state) break;
    q[0] += 0.5 * kPeriod_s;
    REQUIRE(rig.send(q));
  }
  REQUIRE_FALSE(state);
  CHECK(state.error().code == ErrorCode::DeviceFault);
  CHECK(cycles * kPeriod_s <= 0.125);
  for (int i = 0; i < 20; ++i) CHECK_FALSE(rig.cycle());
  CHECK(rig.wire->dq.norm() == 0.0);
  rig.check_judge();
}
