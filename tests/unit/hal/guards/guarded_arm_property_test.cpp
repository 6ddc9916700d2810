// Whatever comes in, what goes out keeps every limit and can come to rest: a million random cycles of bad
// states, bad commands, gaps, lost packets, stops and restarts against a judge at the far end of the wire; as
// many with the limits of mode T1.

#include <catch2/catch.hpp>
#include <random>

#include "hal/guards/braking_law.hpp"
#include "hal/guards/t1_profile.hpp"
#include "judged_arm.hpp"
#include "tests/support/thorough.hpp"

using namespace guards;

namespace {

constexpr int kCycles = colift::tests::repetitions(1'000'000, 100'000);

/// Draws from one seed; own distributions, so that every platform draws the same.
class Dice {
 public:
  explicit Dice(std::uint64_t seed) : bits_(seed) {}
  double uniform(double low, double high) {
    return low + (high - low) * static_cast<double>(bits_() >> 11) * 0x1p-53;
  }
  int below(int n) { return static_cast<int>(bits_() % static_cast<std::uint64_t>(n)); }
  bool chance(double p) { return uniform(0, 1) < p; }
  double nonsense() {
    constexpr std::array<double, 8> kValues = {std::numeric_limits<double>::quiet_NaN(),
                                               std::numeric_limits<double>::infinity(),
                                               -std::numeric_limits<double>::infinity(),
                                               1e300,
                                               -1e300,
                                               1e9,
                                               -2.0,
                                               5e-324};
    return kValues[static_cast<std::size_t>(below(8))];
  }

 private:
  std::mt19937_64 bits_;
};

/// A caller that mostly moves well, up to its limits and towards the ends of the joints, and often not.
class Caller {
 public:
  explicit Caller(const Limits& limits) : limits_(limits) {}

  ImpedanceCommand next(Dice& dice, const JudgedArm& wire, const ArmState& state, double dt) {
    if (dice.chance(0.002))
      for (int i = 0; i < kArmJoints; ++i) drift_[i] = dice.uniform(-1.3, 1.3);
    ImpedanceCommand c;
    c.stiffness_nm_rad.setConstant(dice.uniform(0, limits_.stiffness));
    c.damping_ratio.setConstant(dice.uniform(0, 1));
    c.tau_superposed_nm = wire.tau;
    for (int i = 0; i < kArmJoints; ++i) {
      const JointBounds b{limits_.lower[i], limits_.upper[i], limits_.velocity[i], limits_.acceleration};
      const VelocityRange may = allowed_velocity(wire.q[i], wire.dq[i], dt, b);
      c.q_rad[i] = wire.q[i] + dt * std::clamp(drift_[i] * limits_.velocity[i], may.low, may.high);
      c.tau_superposed_nm[i] += dice.uniform(-0.99, 0.99) * limits_.torque_slope * dt;
      c.tau_superposed_nm[i] = std::clamp(c.tau_superposed_nm[i], -limits_.torque[i], limits_.torque[i]);
    }
    if (wire.must_restart) {
      c.q_rad = state.q_rad;
      c.tau_superposed_nm.setZero();
    }
    if (dice.chance(0.04)) spoil(dice, c);
    if (dice.chance(0.01)) c = old_;  // a target from some time ago
    if (dice.chance(0.01)) old_ = c;
    return c;
  }

 private:
  void spoil(Dice& dice, ImpedanceCommand& c) {
    const int i = dice.below(kArmJoints);
    switch (dice.below(7)) {
      case 0:
        c.q_rad[i] = dice.nonsense();
        break;
      case 1:
        c.stiffness_nm_rad[i] = dice.nonsense();
        break;
      case 2:
        c.damping_ratio[i] = dice.nonsense();
        break;
      case 3:
        c.tau_superposed_nm[i] = dice.nonsense();
        break;
      case 4:
        c.q_rad[i] += dice.uniform(-0.2, 0.2);
        break;
      case 5:
        c.q_rad[i] = dice.uniform(-7, 7);
        break;
      default:
        c.tau_superposed_nm[i] += dice.uniform(-20, 20);
        break;
    }
  }

  Limits limits_;
  JointVector drift_ = JointVector::Zero();
  ImpedanceCommand old_;
};

}  // namespace

TEST_CASE("whatever is commanded and measured, the arm gets nothing that breaks a limit",
          "[guard][property]") {
  const RobotModel& model = built_in_robot();
  const bool t1 = GENERATE(false, true);
  CAPTURE(t1);
  const GuardConfig config = t1 ? in_t1({}) : GuardConfig{};
  const Limits limits(model, config);
  auto owned = std::make_unique<JudgedArm>(limits);
  JudgedArm& wire = *owned;
  GuardedArm arm(std::move(owned), model, config);
  Dice dice(20261121);
  Caller caller(limits);

  constexpr std::array<double, 3> kPeriods_s = {0.001, 0.002, 0.005};
  double period_s = 0.001;
  Timestamp now{0};
  CycleTime time;  // as the caller knows it
  ArmState truth;
  truth.may_command = true;
  for (int i = 0; i < kArmJoints; ++i) truth.q_rad[i] = dice.uniform(limits.lower[i], limits.upper[i]);
  REQUIRE(arm.configure());
  REQUIRE(arm.activate());
  std::uint64_t passed = 0, refused = 0, bad_states = 0;

  for (int cycle = 0; cycle < kCycles && wire.broken.empty(); ++cycle) {
    // life of the device
    if (dice.chance(0.0005)) {
      switch (dice.below(3)) {
        case 0:
          arm.stop();
          break;
        case 1:
          arm.deactivate();
          break;
        default:
          REQUIRE(arm.configure());
          break;
      }
      // where an arm that has stopped is found again: anywhere, now and then beyond the margin
      for (int i = 0; i < kArmJoints; ++i)
        truth.q_rad[i] = dice.uniform(limits.lower[i] - 0.01, limits.upper[i] + 0.01);
      period_s = kPeriods_s[static_cast<std::size_t>(dice.below(3))];
      now += std::chrono::seconds(1);
      REQUIRE(arm.activate());
      time.reset();
    } else if (!wire.must_restart) {
      truth.q_rad = wire.q;  // an arm that follows
      for (int i = 0; i < kArmJoints; ++i) truth.q_rad[i] += dice.uniform(-1e-4, 1e-4);
    }

    // time: one period, a little more or less, some lost, a long gap
    double step_s = period_s;
    if (dice.chance(0.02)) step_s *= dice.uniform(0.8, 1.2);
    if (dice.chance(0.02)) step_s *= 1 + dice.below(8);
    if (dice.chance(0.0005)) step_s = dice.uniform(0.051, 2.0);
    wire.cycle_counts = true;
    Timestamp at = now + Timestamp(static_cast<std::int64_t>(step_s * 1e9));
    if (dice.chance(0.001)) {
      wire.fail_wait = dice.chance(0.5) ? ErrorCode::Timeout : ErrorCode::LinkLost;
      if (*wire.fail_wait == ErrorCode::LinkLost) wire.restart_from_here = true;
      now = at;
    } else if (time.last() && dice.chance(0.005)) {  // doubled or out of order
      at = *time.last() - Timestamp(dice.below(3) * 1'000'000);
      wire.cycle_counts = false;
    } else {
      now = at;
      if (seconds(at - time.last().value_or(at)) > config.stale_s) wire.restart_from_here = true;
      time.advance(at);
    }

    truth.measured_at = at;
    truth.may_command = !dice.chance(0.001);
    if (!truth.may_command && wire.cycle_counts && !wire.fail_wait) wire.restart_from_here = true;
    wire.state = truth;
    if (dice.chance(0.003)) {
      const int i = dice.below(kArmJoints);
      switch (dice.below(4)) {
        case 0:
          wire.state.q_rad[i] = dice.nonsense() * 1e3;
          break;
        case 1:
          wire.state.tau_external_nm[i] = std::numeric_limits<double>::quiet_NaN();
          break;
        case 2:
          wire.state.q_commanded_rad[i] = std::numeric_limits<double>::infinity();
          break;
        default:
          wire.state.tau_nm[i] = std::numeric_limits<double>::quiet_NaN();
          break;
      }
    }
    if (dice.chance(0.0003)) wire.fail_command = true;

    const auto state = arm.wait_cycle();
    if (!state) {
      ++bad_states;
      if (dice.chance(0.1)) (void)arm.command(caller.next(dice, wire, truth, time.step_s()));
      continue;
    }
    REQUIRE(state->q_rad.allFinite());
    if (dice.chance(0.005)) continue;  // nobody answers
    const auto done = arm.command(caller.next(dice, wire, *state, time.step_s()));
    done ? ++passed : ++refused;
    if (dice.chance(0.005)) (void)arm.command(caller.next(dice, wire, *state, time.step_s()));

    if (cycle % 5000 == 0 && !wire.must_restart && wire.state.may_command) {
      // from here, whatever the arm was doing, it comes to rest in the time that its limits allow
      const double longest_s = limits.velocity.maxCoeff() / limits.acceleration;
      for (double s = -2 * period_s; s < longest_s; s += period_s) {
        now += Timestamp(static_cast<std::int64_t>(period_s * 1e9));
        truth.q_rad = wire.q;
        truth.measured_at = now;
        truth.may_command = wire.cycle_counts = true;
        wire.state = truth;
        wire.fail_command = false;
        time.advance(now);
        if (!arm.wait_cycle()) break;
        ImpedanceCommand nonsense;
        nonsense.q_rad.setConstant(std::numeric_limits<double>::quiet_NaN());
        REQUIRE_FALSE(arm.command(nonsense));
      }
      CHECK(wire.dq.cwiseAbs().maxCoeff() < 1e-9);
    }
  }
  INFO("passed " << passed << ", refused " << refused << ", bad states " << bad_states << ", restarts "
                 << wire.restarts << ", near a limit " << wire.near_limit << ", fastest " << wire.fastest);
  CHECK(wire.broken == "");
  // the dice did throw what they were meant to
  CHECK(passed > kCycles / 2);
  CHECK(refused > kCycles / 100);
  CHECK(bad_states > kCycles / 500);
  CHECK(wire.restarts > kCycles / 1000);
  CHECK(wire.near_limit > kCycles / 100);
  CHECK(wire.fastest > 0.999);
}
