#include "sim_hal/mock/mock_arm.hpp"

#include <catch2/catch.hpp>
#include <cmath>

using namespace colift;
using namespace colift::sim_hal;
using hal::ErrorCode;
using Fault = MockArm::Fault;
using std::chrono::milliseconds;

namespace {

struct Rig {
  hal::ManualClock clock;
  MockArm arm;
  explicit Rig(ArmScript script = {}) : arm(std::move(script), clock) {
    REQUIRE(arm.configure());
    REQUIRE(arm.activate());
  }
};

hal::ImpedanceCommand to(double a2_rad) {
  hal::ImpedanceCommand command;
  command.q_rad[1] = a2_rad;
  return command;
}

}  // namespace

TEST_CASE("a mock arm is where it was commanded one cycle later, as far as its speed allows", "[mock][arm]") {
  Rig rig;
  REQUIRE(rig.arm.wait_cycle());
  REQUIRE(rig.arm.command(to(0.005)));
  const auto there = rig.arm.wait_cycle();
  REQUIRE(there);
  CHECK(there->q_rad[1] == 0.005);
  CHECK(there->measured_at == milliseconds(10));
  REQUIRE(rig.arm.command(to(1.0)));
  const auto in_transit = rig.arm.wait_cycle();
  REQUIRE(in_transit);
  // A2 of the LWR 4+ turns with 110 deg/s
  CHECK(in_transit->q_rad[1] == Approx(0.005 + 110.0 / 180.0 * 3.14159265358979 * 0.005));
  CHECK(in_transit->q_commanded_rad[1] == 1.0);
}

TEST_CASE("a mock arm feels what its script says", "[mock][arm]") {
  ArmScript script;
  script.external_nm = [](hal::Timestamp t, const hal::JointVector& q) {
    hal::JointVector tau = hal::JointVector::Constant(hal::seconds(t));
    tau[6] = q[1];
    return tau;
  };
  Rig rig(script);
  REQUIRE(rig.arm.wait_cycle());
  REQUIRE(rig.arm.command(to(0.004)));
  const auto state = rig.arm.wait_cycle();
  REQUIRE(state);
  CHECK(state->tau_external_nm[0] == 0.010);
  CHECK(state->tau_external_nm[6] == 0.004);
}

TEST_CASE("cycles that nobody waited for are gone", "[mock][arm]") {
  Rig rig;
  REQUIRE(rig.arm.wait_cycle());
  CHECK(rig.arm.cycle() == 0U);
  rig.clock.advance(milliseconds(33));
  const auto state = rig.arm.wait_cycle();
  REQUIRE(state);
  CHECK(state->measured_at == milliseconds(40));
  CHECK(rig.arm.cycle() == 7U);
}

TEST_CASE("each fault of a mock arm shows as it should and passes", "[mock][arm]") {
  Rig rig;
  rig.arm.inject(Fault::Freeze, 2);
  rig.arm.inject(Fault::Drop, 4);
  rig.arm.inject(Fault::Jump, 6);
  rig.arm.inject(Fault::Nan, 8);
  const auto cycle = [&] { return rig.arm.wait_cycle(); };
  const auto first = cycle(), good = cycle(), frozen = cycle(), after = cycle();
  REQUIRE(first);
  REQUIRE(good);
  REQUIRE(frozen);
  CHECK(frozen->measured_at == good->measured_at);
  CHECK(after->measured_at == milliseconds(20));

  const auto dropped = cycle();
  REQUIRE_FALSE(dropped);
  CHECK(dropped.error().code == ErrorCode::Timeout);
  CHECK_FALSE(rig.arm.command(to(0.0)));
  CHECK(rig.arm.health().state == hal::DeviceHealth::State::Stalled);
  REQUIRE(cycle());
  CHECK(cycle()->q_rad[1] == Approx(0.3));
  CHECK(cycle()->q_rad[1] == 0.0);
  CHECK(std::isnan(cycle()->q_rad[3]));
  CHECK(cycle()->q_rad.allFinite());
  CHECK(rig.arm.health().rejected == 1);
}

TEST_CASE("a late state is older than the clock, and the next one is fresh", "[mock][arm]") {
  Rig rig;
  rig.arm.inject(Fault::Late, 1);
  REQUIRE(rig.arm.wait_cycle());
  const auto late = rig.arm.wait_cycle();
  REQUIRE(late);
  CHECK(rig.clock.now() - late->measured_at == milliseconds(15));
  const auto fresh = rig.arm.wait_cycle();
  REQUIRE(fresh);
  CHECK(fresh->measured_at == rig.clock.now());
}

TEST_CASE("an unplugged mock arm stands still and comes back when it is configured again", "[mock][arm]") {
  Rig rig;
  rig.arm.inject(Fault::Unplug, 2, 4);
  REQUIRE(rig.arm.wait_cycle());
  REQUIRE(rig.arm.command(to(0.5)));
  REQUIRE(rig.arm.wait_cycle());
  const auto lost = rig.arm.wait_cycle();
  REQUIRE_FALSE(lost);
  CHECK(lost.error().code == ErrorCode::LinkLost);
  const auto stood = rig.arm.q_rad();
  CHECK(rig.arm.configure().error().code == ErrorCode::LinkLost);
  CHECK(rig.arm.wait_cycle().error().code == ErrorCode::LinkLost);
  rig.clock.advance(milliseconds(30));
  REQUIRE(rig.arm.configure());
  REQUIRE(rig.arm.activate());
  CHECK(rig.arm.wait_cycle()->q_rad == stood);
}

TEST_CASE("a mock arm without a period or out of its limits cannot be configured", "[mock][arm]") {
  hal::ManualClock clock;
  ArmScript no_period;
  no_period.period = hal::Duration(0);
  CHECK(MockArm(no_period, clock).configure().error().code == ErrorCode::BadConfig);
  ArmScript outside;
  outside.start_rad[3] = 2.2;
  CHECK(MockArm(outside, clock).configure().error().code == ErrorCode::BadConfig);
}
