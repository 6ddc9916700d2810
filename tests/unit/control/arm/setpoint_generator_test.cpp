// One command for each cycle: the first one, no allocation, nothing for the last gate to refuse.
#include <random>

#include "../allocations.hpp"
#include "hal/guards/guarded_arm.hpp"
#include "setpoint_rig.hpp"

using namespace colift;
using namespace colift::control;
using namespace colift::control::test;

TEST_CASE("the first command is the measured pose, and it is held", "[cycle]") {
  Rig rig;
  CHECK(rig.last.q_rad == home());
  CHECK(rig.last.tau_superposed_nm.norm() == 0.0);
  CHECK(rig.last.stiffness_nm_rad == JointVector::Constant(rig.task.stiffness_nm_rad));
  rig.state.q_rad[2] += 0.01;  // pushed: the set point stays, the spring pushes back
  const JointVector pushed = rig.state.q_rad;
  for (int i = 0; i < 50; ++i) {
    rig.state.q_rad = pushed;
    rig.step();
    CHECK(rig.last.q_rad == home());
  }
  CHECK(rig.cycle.done());
}

TEST_CASE("answering a cycle allocates nothing", "[cycle]") {
  Rig rig;
  REQUIRE(rig.cycle.follow(way({home(), there()})));
  const auto before = allocations();
  for (int i = 0; i < 2000; ++i) {
    rig.state.measured_at += std::chrono::milliseconds(1);
    if (i == 500) rig.cycle.hold();
    if (i == 900) rig.cycle.back();
    if (i == 1500) rig.state.measured_at += std::chrono::milliseconds(100);
    if (i > 1700) rig.cycle.servo(there(), JointVector::Zero());
    rig.state.q_rad = rig.cycle.step(rig.state).q_rad;
  }
  CHECK(allocations() == before);
}

namespace {

/// Far end of the wire that only follows.
class IdealArm final : public hal::Arm {
 public:
  hal::ArmState state;
  hal::Result<> configure() override { return {}; }
  hal::Result<> activate() override { return {}; }
  void deactivate() noexcept override {}
  void stop() noexcept override {}
  hal::DeviceHealth health() const override { return {}; }
  hal::Result<hal::ArmState> wait_cycle() override { return state; }
  hal::Result<> command(const ImpedanceCommand& c) override {
    state.q_rad = c.q_rad;
    return {};
  }
};

}  // namespace

TEST_CASE("the last gate has nothing to refuse, whatever is asked of the cycle and when",
          "[cycle][property]") {
  std::mt19937_64 bits(77);
  const auto uniform = [&] { return static_cast<double>(bits() >> 11) * 0x1p-53; };
  auto owned = std::make_unique<IdealArm>();
  IdealArm& wire = *owned;
  hal::GuardedArm arm(std::move(owned), robot(), hal::GuardConfig{});
  SetpointGenerator cycle(robot(), TaskConfig{});
  wire.state.may_command = true;
  wire.state.q_rad = home();
  REQUIRE(arm.configure());
  REQUIRE(arm.activate());
  JointVector goal = home();
  int done = 0, paths = 0;
  for (int i = 0; i < 200'000; ++i) {
    const auto random_pose = [&] {
      JointVector q;
      for (int j = 0; j < hal::kArmJoints; ++j)
        q[j] =
            (robot().lower_rad()[j] + 0.1) * (1.0 - uniform()) + (robot().upper_rad()[j] - 0.1) * uniform();
      return q.cwiseMax((robot().lower_rad().array() + 0.1).matrix())
          .cwiseMin((robot().upper_rad().array() - 0.1).matrix())
          .eval();
    };
    const double dice = uniform();
    if (dice < 0.002)
      cycle.hold();
    else if (dice < 0.004)
      cycle.resume(uniform());
    else if (dice < 0.006)
      cycle.back(uniform());
    else if (dice < 0.007)
      goal = random_pose();
    else if (dice < 0.008)
      cycle.superpose(JointVector::Constant(200.0 * uniform() - 100.0));
    else if (dice < 0.009)
      cycle.set_stiffness(2000.0 * uniform());
    else if (dice < 0.03 && cycle.at_rest() && cycle.starts() > 0)
      paths += cycle.follow(way({cycle.commanded(), random_pose()})).has_value();
    const bool serve = (i / 20'000) % 2 == 1;
    if (serve) {
      for (int j = 0; j < hal::kArmJoints; ++j) goal[j] += 0.002 * (uniform() - 0.5);
      cycle.servo(goal, 150.0 * JointVector::Constant(uniform() - 0.5));
    }
    double step_s = 0.002;
    if (uniform() < 0.02) step_s *= 1 + static_cast<int>(5 * uniform());
    if (uniform() < 0.0005) step_s = 0.3;
    wire.state.measured_at += hal::Timestamp(static_cast<std::int64_t>(step_s * 1e9));
    wire.state.may_command = uniform() > 0.0005;
    const auto state = arm.wait_cycle();
    REQUIRE(state);
    const auto command = cycle.step(*state);
    if (!state->may_command) continue;
    const auto sent = arm.command(command);
    if (!sent) FAIL("cycle " << i << ": " << sent.error().text());
    done += cycle.done();
  }
  CHECK(paths > 20);
  CHECK(done > 1000);
}
